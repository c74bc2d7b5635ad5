#include "services/sorter/sort_job.h"

#include "engrave/discretize/cloud.h"
#include "engrave/sort/order.h"
#include "engrave/sort/shadow.h"
#include "engrave/sort/travel.h"
#include "proto/options.h"
#include "services/host/worker_threads.h"

namespace intaglio::sorter {

Result<host::StageResult> SortJob(const FrozenJob& job, PointCloud cloud,
                                  const ProgressSink& progress) {
  // No maker of a part can tell that the others are empty as well.
  if (cloud.size() == 0) return tl::unexpected(discretize::NoPoints());
  sort::OrderOptions options = OrderOptionsOf(job);
  options.executor = host::AllCores();
  if (const AnnealOrder& anneal = job.job().ordering().anneal(); anneal.has_time_s()) {
    options.anneal.used_share = host::ShareOfTime(anneal.time_s());
  }
  const auto order = sort::MakeOrder(cloud.points_mm, options, progress);
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
      sort::CountShadowViolations(result.cloud.points_mm, job.optics().cone_tangent()));
  return result;
}

}  // namespace intaglio::sorter
