#include "services/job/plan/point_ticks.h"

#include <utility>

#include "engrave/core/try.h"
#include "engrave/sort/order.h"
#include "services/job/convert/options.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/plan/plan_summary.h"

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
  const auto order =
      INTAGLIO_TRY(sort::MakeChannelOrder(points_mm, masks, options, go_on));
  PointList path_mm;
  PlanInput plan;
  path_mm.reserve(order.size());
  plan.masks.reserve(order.size());
  for (const std::uint32_t index : order) {
    path_mm.push_back(points_mm[index]);
    plan.masks.push_back(masks[index]);
  }
  plan.machine_points_mm = INTAGLIO_TRY(machine::AxesAlong(
      AxesFromGlassOf(job), std::move(path_mm), AxisLimitsOf(job.machine()).travel_mm));
  plan.options = MotionOptionsOf(job);
  auto summary = INTAGLIO_TRY(Summarize(plan, go_on));
  return std::move(summary.point_ticks);
}

}  // namespace intaglio
