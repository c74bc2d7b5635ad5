#include "services/job/models/job_cloud.h"

#include <utility>

#include "engrave/core/try.h"
#include "engrave/discretize/cloud.h"
#include "services/job/models/discretize_outcome.h"
#include "services/job/models/model_sources.h"

namespace intaglio {

Result<JobCloud> MakeJobCloud(const JobSpec& job, const ReadLimits& limits,
                              const Executor& executor,
                              const JobCloudProgress& progress) {
  auto files = INTAGLIO_TRY(ReadFilesOf(job, limits));
  auto sources = INTAGLIO_TRY(MakeSources(job, std::move(files), limits, progress.read));
  auto made = INTAGLIO_TRY(discretize::MakeCloud(sources.sources, CloudOptionsOf(job), {},
                                                 executor, progress.points));
  if (made.cloud.size() == 0) return tl::unexpected(discretize::NoPoints());
  Warnings warnings = WarningsOf(OutcomeOf(sources, made, {}), job);
  return JobCloud{std::move(made.cloud), std::move(warnings)};
}

}  // namespace intaglio
