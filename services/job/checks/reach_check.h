#pragma once

#include <optional>

#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/fields/findings.h"

namespace intaglio {

/// Whether the axes reach every place between the margins of the block, within their
/// travel. `job` with its defaults, and a block; without `stage_per_glass_ratio` the
/// depth is not regarded. Passes over an arm and table that CheckKinematics refuses, and
/// over corrections out of their ranges.
void CheckReach(const JobSpec& job, const MachineSpec& machine,
                std::optional<double> stage_per_glass_ratio, Findings& findings);

}  // namespace intaglio
