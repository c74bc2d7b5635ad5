#include "services/sorter/sort_job.h"

#include <fmt/format.h>

#include <bit>

#include "engrave/core/channels.h"
#include "engrave/core/try.h"
#include "engrave/discretize/cloud.h"
#include "engrave/proof/cloud_quality.h"
#include "engrave/sort/order.h"
#include "engrave/sort/shadow.h"
#include "engrave/sort/travel.h"
#include "services/job/channels.h"
#include "services/job/options.h"
#include "services/job/ordering.h"
#include "services/job/quality_options.h"
#include "services/platform/host/threads/worker_threads.h"

namespace intaglio::sorter {
namespace {

/// Results of a measurement that is independent of how the points were made: points too
/// near, places where the glass may break. Of each block that has points of its own.
void AddWarnings(const FrozenJob& job, const PointCloud& cloud,
                 const std::vector<ChannelMask>& masks, SortOutcome& outcome) {
  proof::QualityOptions options = QualityOptionsOf(job.job(), job.machine());
  options.executor = host::AllCores();
  const std::vector<ChannelMask> channels = DistinctChannels(masks);
  const bool one = channels.size() == 1;
  for (const ChannelMask channel : channels) {
    const PointCloud part = one ? PointCloud() : PointsIn(channel, cloud, masks);
    const auto quality = proof::MeasureCloud(one ? cloud : part, {}, options);
    if (!quality) continue;  // no points: reported before
    for (const std::string& warning : quality->warnings) {
      outcome.add_warnings(
          one ? warning
              : fmt::format("channel {}: {}", std::countr_zero(channel) + 1, warning));
    }
  }
}

std::uint64_t CountChanges(const std::vector<ChannelMask>& masks) {
  std::uint64_t changes = 0;
  for (std::size_t i = 1; i < masks.size(); ++i) changes += masks[i] != masks[i - 1];
  return changes;
}

}  // namespace

Result<host::StageResult> SortJob(const FrozenJob& job, PointCloud cloud,
                                  const ProgressSink& progress) {
  // The maker of one part does not know that the others are empty as well.
  if (cloud.size() == 0) return tl::unexpected(discretize::NoPoints());
  const auto of_cloud = INTAGLIO_TRY(ChannelsOfPoints(job.job(), cloud.source));
  const auto order = INTAGLIO_TRY(
      sort::MakeChannelOrder(cloud.points_mm, of_cloud, host::OrderingOf(job), progress));
  host::StageResult result;
  SortOutcome& outcome = *result.outcome.mutable_sort();
  outcome.set_point_count(order.size());
  outcome.set_travel_mm(sort::MeasureTravel(cloud.points_mm, order).largest_axis_mm);
  result.cloud.points_mm.reserve(order.size());
  result.cloud.source.reserve(order.size());
  std::vector<ChannelMask> masks;
  masks.reserve(order.size());
  for (const std::uint32_t index : order) {
    result.cloud.Add(cloud.points_mm[index], cloud.source[index]);
    masks.push_back(of_cloud[index]);
  }
  cloud = {};
  outcome.set_shadow_violation_count(sort::CountShadowViolations(
      result.cloud.points_mm, masks, job.optics().cone_tangent()));
  outcome.set_shutter_change_count(CountChanges(masks));
  AddWarnings(job, result.cloud, masks, outcome);
  return result;
}

}  // namespace intaglio::sorter
