#include "services/job/plan/point_ticks.h"

#include <utility>

#include "engrave/core/try.h"
#include "services/job/convert/options.h"
#include "services/job/plan/plan_summary.h"
#include "services/job/plan/point_order.h"

namespace intaglio {

Result<std::vector<std::uint32_t>> PointTicks(const FrozenJob& job,
                                              const PointList& points_mm,
                                              std::span<const ChannelMask> masks,
                                              const Executor& executor,
                                              const ProgressSink& progress) {
  const ProgressSink go_on = [&](std::uint64_t done, std::uint64_t total) {
    return !progress || progress(done, total);
  };
  sort::OrderOptions options = OrderOptionsOf(job);
  options.executor = executor;
  const auto order = INTAGLIO_TRY(OrderPoints(job, points_mm, masks, options, go_on));
  auto summary = INTAGLIO_TRY(SummarizeOrder(job, points_mm, masks, order, go_on));
  return std::move(summary.point_ticks);
}

}  // namespace intaglio
