#include "services/client/preview/preview_time.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/machine/axes_from_glass.h"
#include "engrave/sort/local_samples.h"
#include "engrave/sort/order.h"
#include "services/job/convert/options.h"
#include "services/job/machine/head_over_block.h"
#include "services/job/machine/job_ticks_bound.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/plan/point_order.h"
#include "services/job/plan/point_ticks.h"
#include "services/job/plan/steady_ticks.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio::client {
namespace {

constexpr std::size_t kPieces = 8;

using Indices = std::vector<std::uint32_t>;

/// An order that takes seconds in place of one that takes minutes.
FrozenJob WithQuickOrder(FrozenJob job, std::size_t point_count) {
  Ordering& ordering = *job.mutable_job()->mutable_ordering();
  if (ordering.has_anneal() &&
      (point_count > kOwnOrderPoints || ordering.anneal().has_time_s())) {
    ordering.mutable_anneal()->Clear();
    ordering.mutable_anneal()->set_tries_per_point(0);
  }
  return job;
}

/// That of the quick order, where it takes the place of another.
std::string OrderNameOf(const FrozenJob& job) {
  const AnnealOrder& anneal = job.job().ordering().anneal();
  if (anneal.has_tries_per_point() && anneal.tries_per_point() == 0) return "smooth";
  const auto* field = ChosenField(job.job().ordering(), "method");
  return field == nullptr ? "" : field->name();
}

Result<std::uint64_t> TicksOf(const FrozenJob& job, const CloudToTime& cloud,
                              const Indices& piece, bool is_sample,
                              const Executor& executor, const ProgressSink& progress) {
  PointList points_mm;
  std::vector<ChannelMask> masks;
  for (const std::uint32_t i : piece) {
    points_mm.push_back(cloud.points_mm[i]);
    masks.push_back(cloud.masks[i]);
  }
  const auto at = INTAGLIO_TRY(PointTicks(job, points_mm, masks, executor, progress));
  if (!is_sample) return at.back();
  const double ticks = SteadyTicksPerStep(at) * static_cast<double>(piece.size());
  return static_cast<std::uint64_t>(std::llround(ticks));
}

/// The sum over all pieces. Several are planned at once, and one by all workers.
Result<std::uint64_t> TicksOfAll(const FrozenJob& job, const CloudToTime& cloud,
                                 const std::vector<Indices>& pieces,
                                 const Executor& executor, const ProgressSink& progress) {
  std::mutex reporting;
  std::size_t done = 0;
  const auto report = [&](std::size_t more) {
    const std::scoped_lock lock(reporting);
    done += more;
    return !progress || progress(done, pieces.size());
  };
  const ProgressSink share = [&](std::uint64_t, std::uint64_t) { return report(0); };
  const bool alone = pieces.size() == 1;
  std::vector<Result<std::uint64_t>> ticks(pieces.size());
  RunEach(alone ? Executor() : executor, pieces.size(), [&](std::size_t i) {
    ticks[i] =
        TicksOf(job, cloud, pieces[i], !alone, alone ? executor : Executor(), share);
    report(1);
  });
  std::uint64_t sum = 0;
  for (const auto& of_piece : ticks) sum += INTAGLIO_TRY(of_piece);
  return sum;
}

/// Times all points in their order at a head that jumps and dwells, by its controller's
/// times: its clock knows no ticks.
Result<TimePreview> JumpTimeOf(const FrozenJob& job, const CloudToTime& cloud,
                               const ProgressSink& progress) {
  const sort::OrderOptions options = OrderOptionsOf(job);
  const auto order =
      INTAGLIO_TRY(OrderPoints(job, cloud.points_mm, cloud.masks, options, progress));
  PointList path_mm;
  path_mm.reserve(order.size());
  for (const std::uint32_t index : order) path_mm.push_back(cloud.points_mm[index]);
  const auto axes = INTAGLIO_TRY(machine::AxesAlong(
      AxesFromGlassOf(job), path_mm, AxisLimitsOf(job.machine()).travel_mm));
  std::vector<std::uint32_t> energies;
  if (options.jump_layers.energy_from_glass) {
    for (const Vec3& at : path_mm)
      energies.push_back(options.jump_layers.energy_from_glass(at));
  }
  const sort::JumpTime of_jumps =
      sort::TimeOfJumps(axes, JumpTimesOf(job.machine(), job.job().laser()), energies);
  TimePreview time;
  time.set_machining_time_s(of_jumps.total_s());
  time.set_warm_up_s(job.machine().laser().warm_up_s());
  time.set_planned_count(path_mm.size());
  time.set_order(OrderNameOf(job));
  JumpTimePreview& parts = *time.mutable_jumps();
  parts.set_jump_s(of_jumps.jump_s);
  parts.set_delay_s(of_jumps.delay_s);
  parts.set_dwell_s(of_jumps.dwell_s);
  parts.set_z_s(of_jumps.z_s);
  parts.set_pause_s(of_jumps.pause_s);
  parts.set_z_move_count(of_jumps.z_move_count);
  parts.set_pulses_per_point(job.job().laser().pulses_per_point());
  parts.set_energy_change_count(of_jumps.energy_change_count);
  parts.set_list_count(of_jumps.list_count);
  return time;
}

/// Bounds the ticks of all points, whatever was planned of them.
Status AddBound(const FrozenJob& job, const PointList& points_mm,
                const Executor& executor, TimePreview& time) {
  auto axes = INTAGLIO_TRY(machine::AxesAlong(AxesFromGlassOf(job), points_mm,
                                              AxisLimitsOf(job.machine()).travel_mm));
  const auto bound =
      JobTicksBound(job.machine(), std::move(axes), MotionOptionsOf(job), executor);
  if (bound) time.set_ticks_bound(*bound);
  return {};
}

}  // namespace

Result<TimePreview> EstimateTime(const FrozenJob& job, const CloudToTime& cloud,
                                 std::size_t max_planned_points, const Executor& executor,
                                 const ProgressSink& progress) {
  const std::size_t point_count = cloud.points_mm.size();
  Require(point_count > 0 && cloud.masks.size() == point_count,
          "{} points and {} masks to time", point_count, cloud.masks.size());
  if (job.machine().head_over_block().has_jump_and_dwell())
    return JumpTimeOf(job, cloud, progress);
  const bool sweeps = job.job().ordering().has_sweep();
  const std::size_t planned_points =
      max_planned_points * (sweeps ? kSweepSampleRatio : 1);
  const std::vector<Indices> pieces =
      sort::LocalSamples(cloud.points_mm, kPieces,
                         std::max<std::size_t>(1, planned_points / kPieces), sweeps);
  const FrozenJob quick = WithQuickOrder(job, point_count);
  const auto planned_ticks =
      INTAGLIO_TRY(TicksOfAll(quick, cloud, pieces, executor, progress));
  std::uint64_t planned_count = 0;
  for (const Indices& piece : pieces) planned_count += piece.size();
  const double all_per_planned =
      static_cast<double>(point_count) / static_cast<double>(planned_count);
  const double ticks = std::round(static_cast<double>(planned_ticks) * all_per_planned);
  TimePreview time;
  time.set_ticks(static_cast<std::uint64_t>(ticks));
  time.set_rate_hz(job.job().laser().rate_hz());
  time.set_machining_time_s(ticks / time.rate_hz());
  time.set_warm_up_s(job.machine().laser().warm_up_s());
  time.set_utilisation(static_cast<double>(point_count) / std::max(1.0, ticks));
  time.set_planned_count(planned_count);
  time.set_order(OrderNameOf(quick));
  INTAGLIO_TRY(AddBound(job, cloud.points_mm, executor, time));
  return time;
}

}  // namespace intaglio::client
