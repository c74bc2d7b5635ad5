#pragma once

// The sizes of a job's models before the job is submitted.

#include "engrave/core/result.h"
#include "proto/job.pb.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

/// Reads the meshes and drawings whose size no fit decides, from this machine's disks,
/// and compares their bounding boxes with their block. kOutsideBlock for a size that is
/// refused (engrave/mesh/plausible_size.h), with the units that would fit; errors of a
/// file that cannot be read. Files of more than 64 MiB are left to the discretizer. `job`
/// with its defaults filled in.
Status CheckUnfittedSizes(const JobSpec& job, const ReadLimits& limits);

}  // namespace intaglio
