#pragma once

// The cloud of a job, made whole in one process, as the discretizers of a shop make it in
// parts.

#include "engrave/core/executor.h"
#include "engrave/core/geometry.h"
#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "proto/job.pb.h"
#include "services/job/models/read_limits.h"

namespace intaglio {

struct JobCloud {
  PointCloud cloud;  ///< glass frame, one point or more
  Warnings warnings;
};

/// How far reading the files is, and then making the points.
struct JobCloudProgress {
  ProgressSink read, points;
};

/// Errors: those of the models, with the file's name; no points; kCancelled.
Result<JobCloud> MakeJobCloud(const JobSpec& job, const ReadLimits& limits,
                              const Executor& executor, const JobCloudProgress& progress);

}  // namespace intaglio
