#pragma once

// Whether a profile's lenses, head and fixtures are possible, whether the foci of its
// lenses are known, and whether the travel of z keeps them above the table.

#include <vector>

#include "engrave/core/result.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// Of a profile whose ranges, kinematics and lenses are good.
void CheckHead(const MachineSpec& machine, std::vector<Error>& errors);

/// Why a job for the lens `name` cannot know where its focus is in z: neither a zero was
/// taught for it in this channel, nor have both it and zero_lens a working_distance_mm.
/// Empty: it can.
std::string WhyFocusIsUnknown(const MachineSpec& machine, const std::string& name,
                              std::uint32_t channel);

/// What `intaglio machine check` says besides the errors; each begins with the field's
/// path. Of a profile that passes CheckMachine.
std::vector<Error> LensWarningsOf(const MachineSpec& machine);

}  // namespace intaglio
