#pragma once

// Which length the arm over a rotary table needs for a block (engrave/machine/
// arm_length.h).

#include <optional>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/machine/arm_length.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// For a box of the machine frame, mm, in which a block lies at the job's station.
/// nullopt: no arm reaches all of it. Of a machine with an arm and a table that
/// CheckKinematics passes.
std::optional<machine::ArmLengths> ArmLengthsFor(const MachineSpec& machine,
                                                 const JobSpec& job,
                                                 const Box3& places_mm);

/// "an arm of 172.7 to 225.3 mm reaches all of the block there, polar.arm_length_mm is
/// 150", or that no length does. Arguments as of ArmLengthsFor.
std::string ArmRemedy(const MachineSpec& machine, const JobSpec& job,
                      const Box3& places_mm);

/// The lengths for blocks of 50 x 50 and 100 x 100 mm at block_origin_mm, a sentence
/// each. Empty: the machine has no arm over a table. Of a profile that CheckMachine
/// passes.
std::vector<std::string> ArmNotesOf(const MachineSpec& machine);

}  // namespace intaglio
