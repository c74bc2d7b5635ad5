#pragma once

// What the lens and the arrangement of several pieces allow of a block. `job` with its
// defaults filled in.

#include <optional>

#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/fields/findings.h"

namespace intaglio {

/// The lens is one of the machine's, its focus is known in z (head_check.h), the block
/// fits under it, and no model is higher than it reaches (head_clearance.h), which is
/// asked with `stage_per_glass_ratio` alone.
void CheckLens(const JobSpec& job, const MachineSpec& machine,
               std::optional<double> stage_per_glass_ratio, Findings& findings);

/// Several pieces at once are next to each other on the table (Trochimczuk 2008 table 10:
/// four of at most 100 mm): MachineSpec.max_divided_block_mm.
void CheckDividedBlock(const JobSpec& job, const MachineSpec& machine,
                       Findings& findings);

}  // namespace intaglio
