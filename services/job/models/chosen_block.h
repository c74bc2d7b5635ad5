#pragma once

// The block of a job that names none.

#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

/// The models decide: their joint size and a margin, in whole steps. What was chosen, and
/// sizes that are unusual for the machine (engrave/mesh/plausible_size.h), are added to
/// `notes`; a size that no block of the machine holds is an error.
Status ChooseBlock(JobSpec& job, const MachineSpec& machine, const ReadLimits& limits,
                   std::vector<std::string>& notes);

/// Points decide by where they are in the block as well as by their extent.
Vector3 BlockAround(const PointList& points_mm);

}  // namespace intaglio
