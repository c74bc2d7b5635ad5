#include "services/job/plan/ordering.h"

#include "services/job/convert/options.h"
#include "services/platform/host/threads/worker_threads.h"

namespace intaglio::host {

sort::OrderOptions OrderingOf(const FrozenJob& job) {
  sort::OrderOptions options = OrderOptionsOf(job);
  options.executor = AllCores();
  if (const AnnealOrder& anneal = job.job().ordering().anneal(); anneal.has_time_s()) {
    options.anneal.used_share = ShareOfTime(anneal.time_s());
  }
  return options;
}

}  // namespace intaglio::host
