#pragma once

// The stage under a scan head that carries the block: of a profile, and whether a job's
// block_place is one that it reaches.

#include <vector>

#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/fields/findings.h"

namespace intaglio {

/// Its axes, besides ranges. Of a profile without such a stage: nothing.
void CheckBlockStage(const MachineSpec& machine, std::vector<Error>& errors);

/// A place on a machine without such a stage, or one beyond its travel, by field.
void CheckBlockPlace(const JobSpec& job, const MachineSpec& machine, Findings& findings);

}  // namespace intaglio
