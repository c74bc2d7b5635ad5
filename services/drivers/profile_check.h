#pragma once

// A machine profile against its drivers: what they need of it, and what the controllers
// on its lines report. Each error begins with the field of the profile, "field: value,
// what is wrong, remedy".

#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

/// What keeps its drivers from being made, whatever is connected. A profile without a
/// device is no mistake: the program at the machine may give it.
std::vector<Error> CheckDrivers(const MachineSpec& machine);

/// What the motion controller reports and the profile has otherwise. `machine` passes
/// CheckMachine and CheckDrivers. Blocks for some seconds at most, commands no motion and
/// no pulse. An error: why nothing was compared; kUnsupported: this family reports
/// nothing through its driver.
Result<std::vector<Error>> CompareMotionController(const MachineSpec& machine,
                                                   const link::SteadyClock& clock);
/// The same of the controller on mark_line.
Result<std::vector<Error>> CompareMarkController(const MachineSpec& machine,
                                                 const link::SteadyClock& clock);

}  // namespace intaglio::drivers
