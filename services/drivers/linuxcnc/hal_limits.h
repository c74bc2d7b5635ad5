#pragma once

// What a LinuxCNC machine was started with, against a profile: the identity that
// deploy/linuxcnc/start keeps in the folder of the machine, and the limits that the
// machine's HAL file sets. Reading them commands nothing.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"
#include "services/drivers/linuxcnc/hal_text.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

/// The finite numbers that a HAL file sets: "setp PIN VALUE", by pin, the last one of
/// each. Lines that are anything else are passed over.
std::map<std::string, double> ParseHalPins(std::string_view text);

/// What the driver needs of a profile: one channel, and nothing that the family has not.
std::vector<Error> CheckLinuxcncProfile(const MachineSpec& machine);

/// `machine` passes CheckMachine; a pin that is not set is not compared.
std::vector<Error> CompareHal(const MachineSpec& machine, const HalIdentity& identity,
                              const std::map<std::string, double>& pins);

/// The same of a cutter (linuxcnc-course): its travel, speed and acceleration, and how
/// far an axis is behind its row at full speed by the drive of the profile, for the gate
/// ends the beam there.
std::vector<Error> CompareBeamHal(const MachineSpec& machine, const HalIdentity& identity,
                                  const std::map<std::string, double>& pins);

/// Both files of the folder that motion_line.device names; the two others are not used.
Result<std::vector<Error>> CompareLinuxcnc(const MachineSpec& machine,
                                           const link::StreamOpener& open,
                                           const link::SteadyClock& clock);
/// The same of mark_line.device.
Result<std::vector<Error>> CompareLinuxcncCourse(const MachineSpec& machine,
                                                 const link::StreamOpener& open,
                                                 const link::SteadyClock& clock);

}  // namespace intaglio::drivers
