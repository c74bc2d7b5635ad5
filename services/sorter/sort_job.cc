#include "services/sorter/sort_job.h"

#include "engrave/discretize/cloud.h"
#include "engrave/proof/cloud_quality.h"
#include "engrave/sort/order.h"
#include "engrave/sort/shadow.h"
#include "engrave/sort/travel.h"
#include "proto/options.h"
#include "proto/quality_options.h"
#include "services/host/ordering.h"
#include "services/host/worker_threads.h"

namespace intaglio::sorter {
namespace {

/// What a measurer that had no part in making the points finds: points too near, places
/// where the glass may break.
void AddWarnings(const FrozenJob& job, const PointCloud& cloud, SortOutcome& outcome) {
  proof::QualityOptions options = QualityOptionsOf(job.job(), job.machine());
  options.executor = host::AllCores();
  const auto quality = proof::MeasureCloud(cloud, {}, options);
  if (!quality) return;  // no points: said before
  for (const std::string& warning : quality->warnings) outcome.add_warnings(warning);
}

}  // namespace

Result<host::StageResult> SortJob(const FrozenJob& job, PointCloud cloud,
                                  const ProgressSink& progress) {
  // No maker of a part can tell that the others are empty as well.
  if (cloud.size() == 0) return tl::unexpected(discretize::NoPoints());
  const auto order = sort::MakeOrder(cloud.points_mm, host::OrderingOf(job), progress);
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
  AddWarnings(job, result.cloud, outcome);
  return result;
}

}  // namespace intaglio::sorter
