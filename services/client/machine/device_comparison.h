#pragma once

// What the devices of a machine report, against its profile. Reading a device commands
// neither motion nor a pulse: it opens the line, takes what the device reports of itself
// and closes the line again.

#include <optional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"
#include "services/platform/link/laser_protocol.h"
#include "services/platform/link/motion_protocol.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::client {

/// What differs, each "field: value of the profile, what the device reports; remedy".
/// `machine` passes CheckMachine. `accessories`: of a controller that reports none, all
/// 0.
std::vector<Error> CompareLaser(const MachineSpec& machine,
                                const link::LaserIdentity& reported,
                                const link::AccessoryState& accessories = {});
/// Without a tolerance or a speed the controller is one that does not report it.
std::vector<Error> CompareStage(const MachineSpec& machine,
                                const link::MotionIdentity& reported,
                                const std::optional<link::StageTolerance>& tolerance,
                                const std::optional<link::StageSpeed>& speed = {});

struct DeviceComparison {
  std::string line;          ///< "laser_line", "motion_line" or "mark_line"
  std::string not_compared;  ///< why it was not compared; empty: it was
  std::vector<Error> differences;
};

/// What is wrong with the profile for its drivers (drivers::CheckDrivers).
std::vector<Error> CheckDriversOf(const MachineSpec& machine);

/// Both lines of the profile, or its mark_line. A line that another program has, that
/// leads nowhere or whose protocol has no identity is not compared, and not disturbed; a
/// device that does not answer takes a second.
std::vector<DeviceComparison> CompareDevices(const MachineSpec& machine,
                                             const link::SteadyClock& clock);

}  // namespace intaglio::client
