#pragma once

// The settings of a controller of the grbl family against a machine profile: what the
// driver needs of either, and where the controller would shape or stop what is planned
// with the profile. Each difference names the field of the profile, the setting, both
// values, and what to do.
//
// Source: gnea/grbl wiki "Grbl v1.1 Configuration" ($10 to $132).

#include <map>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

struct GrblSettings {
  std::string version, serial_number;  ///< of $I
  std::map<int, double> values;        ///< of $$, by number
};

/// What the driver needs of a profile: laser.max_unsettled_points, one channel, and
/// nothing that the family has not.
std::vector<Error> CheckGrblProfile(const MachineSpec& machine);

/// `machine` passes CheckMachine. A setting that the controller does not report is not
/// compared, but for those that the driver needs.
std::vector<Error> CompareGrbl(const MachineSpec& machine, const GrblSettings& settings);

/// Asks a controller at rest for $I and $$, for up to 4 s: an Arduino starts again when
/// its port is opened. Before, it is reset at rest (0x18: dark, and it forgets half a
/// line of an earlier host); nothing else is commanded. An error: it does not answer, or
/// it is not idle, and then it is left alone.
Result<GrblSettings> ReadGrblSettings(const link::StreamOpener& open,
                                      const link::SteadyClock& clock);

/// Both of the above on the machine's line.
Result<std::vector<Error>> CompareGrblController(const MachineSpec& machine,
                                                 const link::StreamOpener& open,
                                                 const link::SteadyClock& clock);

}  // namespace intaglio::drivers
