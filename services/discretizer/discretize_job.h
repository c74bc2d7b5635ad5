#pragma once

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "services/discretizer/model_intake.h"
#include "services/host/stage_task.h"

namespace intaglio::discretizer {

/// From the files of the job's models to its points, glass frame, mm. Errors name the
/// model's file, or how many points lie outside the block and where.
Result<host::StageResult> DiscretizeJob(const FrozenJob& job,
                                        std::vector<FileBytes> files,
                                        const ProgressSink& progress);

}  // namespace intaglio::discretizer
