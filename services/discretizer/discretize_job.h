#pragma once

#include <memory>
#include <vector>

#include "engrave/core/executor.h"
#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "proto/task.pb.h"
#include "services/job/models/model_sources.h"
#include "services/platform/host/stage/stage_task.h"

namespace intaglio::discretizer {

/// A job's models, read and placed once for all of its parts. Of many threads.
struct PreparedJob {
  JobSpec job;
  JobSources sources;
};

/// `files` as FilesOf (services/job/convert/model_kind.h) names them. Errors name the
/// model's file.
Result<std::shared_ptr<const PreparedJob>> PrepareJob(const FrozenJob& job,
                                                      std::vector<FileBytes> files,
                                                      const ReadLimits& limits,
                                                      const ProgressSink& progress);

/// The marks of a job of marks, which has no parts. Errors as of MakeMarks.
Result<host::StageResult> MakeMarksOf(const FrozenJob& job, std::vector<FileBytes> files,
                                      const ReadLimits& limits,
                                      const ProgressSink& progress);

/// The points of one part of the job, glass frame, mm, from the lowest up; the parts one
/// after another are the same cloud, bit for bit, however many they are. kOutsideBlock:
/// how many points lie outside the block and where. kMissing: the whole job has none.
Result<host::StageResult> DiscretizePart(const PreparedJob& prepared,
                                         const discretize::Part& part,
                                         const Executor& executor,
                                         const ProgressSink& progress);

}  // namespace intaglio::discretizer
