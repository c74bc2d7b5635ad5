#include "services/sorter/sort_job.h"

#include "engrave/core/channels.h"
#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/discretize/cloud.h"
#include "engrave/sort/order.h"
#include "engrave/sort/shadow.h"
#include "engrave/sort/travel.h"
#include "services/job/convert/options.h"
#include "services/job/fields/channels.h"
#include "services/job/machine/head_clearance.h"
#include "services/job/marks/mark_maker.h"
#include "services/job/plan/first_estimate.h"
#include "services/job/plan/ordering.h"
#include "services/job/plan/point_order.h"
#include "services/job/quality/cloud_warnings.h"
#include "services/job/quality/focus_spread.h"
#include "services/job/quality/oblique_beams.h"
#include "services/job/quality/pulse_focus.h"
#include "services/job/verdict/warnings.h"
#include "services/platform/host/threads/worker_threads.h"

namespace intaglio::sorter {
namespace {

std::uint64_t CountChanges(const std::vector<ChannelMask>& masks) {
  std::uint64_t changes = 0;
  for (std::size_t i = 1; i < masks.size(); ++i) changes += masks[i] != masks[i - 1];
  return changes;
}

}  // namespace

Result<host::StageResult> SortJob(const FrozenJob& job, PointCloud cloud, OrderMemo& memo,
                                  std::atomic<std::uint64_t>& estimate_ticks,
                                  const ProgressSink& progress) {
  // The maker of one part does not know that the others are empty as well.
  if (cloud.size() == 0) return tl::unexpected(discretize::NoPoints());
  const auto of_cloud = INTAGLIO_TRY(ChannelsOfPoints(job.job(), cloud.source));
  // Without an estimate the job goes on: what is wrong, the order or the cell reports.
  const bool whole = EstimatesWhole(job, cloud.size());
  if (!whole) {
    const auto estimate =
        FirstEstimateTicks(job, cloud.points_mm, of_cloud, host::AllCores(), progress);
    if (estimate) estimate_ticks = *estimate;
  }
  const std::string key =
      memo.Keeps(cloud.size()) ? OrderKey(job, cloud.points_mm, of_cloud) : std::string();
  std::optional<sort::Order> known = memo.Find(key);
  if (!known) {
    known = INTAGLIO_TRY(
        OrderPoints(job, cloud.points_mm, of_cloud, host::OrderingOf(job), progress));
    memo.Keep(key, *known);
  }
  const sort::Order& order = *known;
  if (whole) {
    const auto plan = SummarizeOrder(job, cloud.points_mm, of_cloud, order,
                                     [](std::uint64_t, std::uint64_t) { return true; });
    if (plan) estimate_ticks = plan->ticks;
  }
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
  INTAGLIO_TRY(CheckHeadClearance(job, result.cloud.points_mm, PointOrder::kOfEngraving));
  outcome.set_shadow_violation_count(
      sort::CountShadowViolations(result.cloud.points_mm, masks, PointConeOf(job)));
  outcome.set_shutter_change_count(CountChanges(masks));
  const CloudFindings found =
      FindInCloud(job.job(), job.machine(), result.cloud, masks, host::AllCores());
  AddTo(*outcome.mutable_warnings(), FocusSpreadOf(job, result.cloud.points_mm));
  AddTo(*outcome.mutable_warnings(), PulseWarningsOf(job));
  if (const auto oblique =
          ObliqueFiguresOf(job, result.cloud.points_mm, result.cloud.source)) {
    INTAGLIO_TRY(CheckOblique(job, *oblique));
    AddTo(*outcome.mutable_warnings(), ObliqueWarningsOf(*oblique));
  }
  AddTo(*outcome.mutable_warnings(), found.warnings);
  return result;
}

Result<host::StageResult> SortMarks(const FrozenJob& job, mark::MarkSet marks,
                                    const ProgressSink& progress) {
  const std::size_t count = marks.marks.size();
  host::StageResult result;
  Warnings warnings;
  result.marks = INTAGLIO_TRY(
      OrderMarks(job.job(), job.machine(), std::move(marks), warnings, progress));
  Require(result.size() == count, "an order of {} marks for {}", result.size(), count);
  SortOutcome& outcome = *result.outcome.mutable_sort();
  outcome.set_point_count(count);
  AddTo(*outcome.mutable_warnings(), warnings);
  return result;
}

}  // namespace intaglio::sorter
