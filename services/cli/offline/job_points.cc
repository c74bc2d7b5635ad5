#include "services/cli/offline/job_points.h"

#include <utility>

#include "engrave/core/try.h"
#include "engrave/discretize/cloud.h"
#include "services/cli/offline/offline_steps.h"
#include "services/job/models/discretize_outcome.h"
#include "services/job/models/model_sources.h"
#include "services/job/options.h"
#include "services/platform/host/threads/worker_threads.h"

namespace intaglio::cli {

Result<MadeCloud> MakePoints(const JobSpec& job, const ReadLimits& limits) {
  auto files = INTAGLIO_TRY(ReadFilesOf(job, limits));
  Meter meter("discretize", Meter::Of::kShares);
  auto sources = INTAGLIO_TRY(MakeSources(job, std::move(files), limits, meter.Sink()));
  auto made = INTAGLIO_TRY(discretize::MakeCloud(sources.sources, CloudOptionsOf(job), {},
                                                 host::AllCores(), meter.Sink()));
  if (made.cloud.size() == 0) return tl::unexpected(discretize::NoPoints());
  Warnings warnings = WarningsOf(OutcomeOf(sources, made, {}), job);
  return MadeCloud{std::move(made.cloud), std::move(warnings)};
}

}  // namespace intaglio::cli
