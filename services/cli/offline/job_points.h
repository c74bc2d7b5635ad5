#pragma once

// The cloud of a job, made in this process as the discretizers of a shop make it.

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "proto/job.pb.h"
#include "services/job/models/read_limits.h"

namespace intaglio::cli {

struct MadeCloud {
  PointCloud cloud;  ///< glass frame, one point or more
  Warnings warnings;
};

/// With a progress bar. Errors: those of the models, with the file's name; no points.
Result<MadeCloud> MakePoints(const JobSpec& job, const ReadLimits& limits);

}  // namespace intaglio::cli
