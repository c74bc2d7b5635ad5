#include "services/job/plan/point_order.h"

#include <utility>

#include "engrave/core/try.h"
#include "services/job/convert/options.h"
#include "services/job/convert/rows.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio {
namespace {

// What rows may save is not worth their plan where so little is left.
constexpr double kNearTheBound = 1.01;

bool MayBeginWithRows(const FrozenJob& job, const PointList& points_mm) {
  return points_mm.size() > 1 && !job.machine().has_head_over_block() &&
         job.job().ordering().has_anneal() && FindLatticeDistance(job.job());
}

sort::OrderOptions WithRows(const FrozenJob& job, sort::OrderOptions options) {
  BoustrophedonOrder rows;
  FillRows(rows, job.job());
  options.boustrophedon = RowOptionsOf(job, rows);
  options.anneal.start = sort::AnnealStart::kRows;
  return options;
}

}  // namespace

Result<sort::Order> OrderPoints(const FrozenJob& job, const PointList& points_mm,
                                std::span<const ChannelMask> masks,
                                const sort::OrderOptions& options,
                                const ProgressSink& progress) {
  const auto order_by = [&](const sort::OrderOptions& by) {
    return sort::MakeChannelOrder(points_mm, masks, by, progress);
  };
  if (!MayBeginWithRows(job, points_mm)) return order_by(options);
  const sort::OrderOptions with_rows = WithRows(job, options);
  // An order that the axes do not reach is reported where it is used.
  const auto ticks_of = [&](sort::Method method) -> Result<std::uint64_t> {
    sort::OrderOptions by = with_rows;
    by.method = method;
    const auto go_on = [&](std::uint64_t, std::uint64_t) {
      return !progress || progress(0, points_mm.size());
    };
    const auto order = INTAGLIO_TRY(sort::MakeChannelOrder(points_mm, masks, by, go_on));
    return INTAGLIO_TRY(SummarizeOrder(job, points_mm, masks, order, go_on)).ticks;
  };
  const auto smooth = ticks_of(sort::Method::kSmooth);
  if (!smooth || static_cast<double>(*smooth) <=
                     kNearTheBound * static_cast<double>(points_mm.size())) {
    return order_by(options);
  }
  const auto rows = ticks_of(sort::Method::kBoustrophedon);
  return order_by(rows && *rows < *smooth ? with_rows : options);
}

Result<PlanSummary> SummarizeOrder(const FrozenJob& job, const PointList& points_mm,
                                   std::span<const ChannelMask> masks,
                                   const sort::Order& order,
                                   const ProgressSink& progress) {
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
  return Summarize(plan, progress);
}

}  // namespace intaglio
