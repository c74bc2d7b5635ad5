#include "services/sorter/sort_job.h"

#include "engrave/sort/order.h"
#include "engrave/sort/shadow.h"
#include "engrave/sort/travel.h"
#include "proto/options.h"

namespace intaglio::sorter {

Result<host::StageResult> SortJob(const FrozenJob& job, PointCloud cloud,
                                  const ProgressSink& progress) {
  const double cone_tangent = job.optics().cone_tangent();
  const auto order =
      sort::MakeOrder(cloud.points_mm, OrderOptionsOf(job.job(), cone_tangent), progress);
  if (!order) return tl::unexpected(order.error());
  host::StageResult result;
  SortOutcome& outcome = *result.outcome.mutable_sort();
  outcome.set_point_count(order->size());
  outcome.set_travel_mm(sort::MeasureTravel(cloud.points_mm, *order).largest_axis_mm);
  result.cloud.points_mm.reserve(order->size());
  result.cloud.source.reserve(order->size());
  for (const std::uint32_t index : *order) {
    result.cloud.Add(cloud.points_mm[index], cloud.source[index]);
  }
  cloud = {};
  outcome.set_shadow_violation_count(
      sort::CountShadowViolations(result.cloud.points_mm, cone_tangent));
  return result;
}

}  // namespace intaglio::sorter
