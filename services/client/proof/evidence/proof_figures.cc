#include "services/client/proof/evidence/proof_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/formats/journal_file.h"
#include "engrave/machine/axes_from_glass.h"
#include "engrave/proof/glass_comparison.h"
#include "engrave/sort/shadow.h"
#include "services/client/proof/evidence/pulse_figures.h"
#include "services/job/convert/options.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/job_ticks_bound.h"
#include "services/job/machine/machine_axes.h"
#include "services/platform/host/process/freed_memory.h"
#include "services/platform/host/threads/worker_threads.h"

namespace intaglio::client {
namespace {

using formats::PointHistory;
using formats::PointOutcome;

bool WasNeverTried(const PointHistory& point) {
  return (point.outcome == PointOutcome::kSkipped ||
          point.outcome == PointOutcome::kLeftOut ||
          point.outcome == PointOutcome::kNone) &&
         !point.open_intent && !point.reopened;
}

/// What the journal has of a point, beside its crack.
enum class Journaled : std::uint8_t { kOther, kMade, kMissed, kNeverTried };

/// By place in the order; the history is released.
std::vector<Journaled> Condense(std::vector<PointHistory>& history) {
  std::vector<Journaled> of_points;
  of_points.reserve(history.size());
  for (const PointHistory& point : std::exchange(history, {})) {
    of_points.push_back(WasNeverTried(point)                     ? Journaled::kNeverTried
                        : point.outcome == PointOutcome::kMade   ? Journaled::kMade
                        : point.outcome == PointOutcome::kMissed ? Journaled::kMissed
                                                                 : Journaled::kOther);
  }
  return of_points;
}

void Count(const std::vector<Journaled>& of_points, const proof::GlassComparison& glass,
           PointCounts& counts) {
  counts.set_planned(glass.planned_count);
  counts.set_made(glass.made_count);
  counts.set_doubled(glass.doubled_count);
  std::uint64_t skipped = 0, missed = 0, unaccounted = 0;
  for (std::size_t i = 0; i < of_points.size(); ++i) {
    const Journaled journaled = of_points[i];
    const bool crack = glass.cracks_of_point[i] > 0;
    if (crack && journaled == Journaled::kMade) continue;
    if (!crack && journaled == Journaled::kNeverTried) {
      ++skipped;
    } else if (!crack && journaled == Journaled::kMissed) {
      ++missed;
    } else {
      ++unaccounted;
    }
  }
  counts.set_skipped(skipped);
  counts.set_missed(missed);
  counts.set_unaccounted(unaccounted);
}

void AddChannels(const proof::GlassComparison& glass,
                 const std::vector<ChannelMask>& masks, JobReport& report) {
  ChannelMask used = 0;
  for (const ChannelMask mask : masks) used |= mask;
  if (std::has_single_bit(used)) return;
  for (std::uint32_t i = 0; i < kMaxChannels; ++i) {
    const proof::ChannelGlass& channel = glass.channels[i];
    if (channel.planned_count + channel.stray_count == 0) continue;
    ChannelCounts& counts = *report.add_channels();
    counts.set_channel(i + 1);
    counts.set_planned(channel.planned_count);
    counts.set_made(channel.made_count);
    counts.set_doubled(channel.doubled_count);
    counts.set_stray(channel.stray_count);
  }
}

/// What was made, in which order, and how long it took.
struct MadeOrder {
  std::vector<std::uint32_t> points;  ///< places in the plan
  std::uint64_t ticks = 0;            ///< from the first to the last pulse; 0: none
};

void AddErrors(const proof::AxisErrors& measured, PositionErrors& errors) {
  errors.set_rms_um(measured.rms_um);
  errors.set_max_um(measured.max_um);
  errors.set_rms_x_um(measured.axis_rms_um.x());
  errors.set_rms_y_um(measured.axis_rms_um.y());
  errors.set_rms_z_um(measured.axis_rms_um.z());
}

void AddCracks(const proof::Cracks& cracks, JobReport& report) {
  if (cracks.size() > 1) {
    report.set_measured_spacing_in_glass_mm(
        proof::MinSpacing(cracks.positions_mm, cracks.channels, host::AllCores()));
    host::ReturnFreedMemory();
  }
  (*report.mutable_checksums())["glass"] = PointChecksum(cracks.positions_mm);
}

/// Releases the history and the ticks of the cracks.
MadeOrder MeasureGlass(Evidence& evidence, JobReport& report) {
  const std::vector<Journaled> of_points = Condense(evidence.history);
  auto glass = proof::CompareGlass(evidence.plan_mm, evidence.masks, evidence.cracks,
                                   report.min_spacing_mm() / 2);
  evidence.cracks.ticks = {};
  host::ReturnFreedMemory();
  PointCounts& counts = *report.mutable_points();
  Count(of_points, glass, counts);
  counts.set_stray(glass.stray_count + evidence.cracks_elsewhere_count);
  AddChannels(glass, evidence.masks, report);
  AddErrors(glass.errors, *report.mutable_position_errors());
  return {std::move(glass.made_order),
          evidence.cracks.size() == 0 ? 0 : glass.last_tick - glass.first_tick + 1};
}

/// Ticks of one power-up; of several the sum of what each took.
std::uint64_t TicksOf(const Evidence& evidence, const std::vector<std::uint32_t>& made) {
  std::uint64_t ticks = 0;
  for (std::size_t first = 0; first < made.size();) {
    const std::uint32_t power_up = evidence.history[made[first]].power_up;
    std::size_t last = first;
    while (last + 1 < made.size() &&
           evidence.history[made[last + 1]].power_up == power_up) {
      ++last;
    }
    ticks += evidence.history[made[last]].tick - evidence.history[made[first]].tick + 1;
    first = last + 1;
  }
  return ticks;
}

MadeOrder CountByController(const Evidence& evidence, JobReport& report) {
  PointCounts& counts = *report.mutable_points();
  counts.set_planned(evidence.plan_mm.size());
  MadeOrder order;
  for (std::uint32_t i = 0; i < evidence.history.size(); ++i) {
    const PointHistory& point = evidence.history[i];
    if (point.fired_count > 1) counts.set_doubled(counts.doubled() + 1);
    if (point.outcome == PointOutcome::kMade && !point.open_intent) {
      counts.set_made(counts.made() + 1);
      order.points.push_back(i);
    } else if (point.outcome == PointOutcome::kMissed) {
      counts.set_missed(counts.missed() + 1);
    } else if (WasNeverTried(point)) {
      counts.set_skipped(counts.skipped() + 1);
    } else {
      counts.set_unaccounted(counts.unaccounted() + 1);
    }
  }
  const auto rank = [&](std::uint32_t point) {
    const auto& power_ups = evidence.power_ups;
    return std::find(power_ups.begin(), power_ups.end(),
                     evidence.history[point].power_up) -
           power_ups.begin();
  };
  std::stable_sort(order.points.begin(), order.points.end(),
                   [&](std::uint32_t a, std::uint32_t b) {
                     return std::pair(rank(a), evidence.history[a].tick) <
                            std::pair(rank(b), evidence.history[b].tick);
                   });
  order.ticks = TicksOf(evidence, order.points);
  return order;
}

/// Whether the bound is known of the whole: all points made in one power-up, each at a
/// tick, with moves between them that are those of the glass. Blocks under several
/// channels have corners of their own. A folder may lack what the bound is computed from.
bool HasBound(const Evidence& evidence, const JobReport& report) {
  const FrozenJob& job = evidence.job;
  const motion::Limits limits = AxisLimitsOf(job.machine());
  return limits.max_speed_mm_s.minCoeff() > 0 &&
         limits.max_acceleration_mm_s2.minCoeff() > 0 &&
         job.optics().stage_per_glass_ratio() > 0 && evidence.power_ups.size() <= 1 &&
         report.points().made() == evidence.plan_mm.size() &&
         job.machine().pulse_trigger() == PULSE_TRIGGER_AT_TICK &&
         BlockOriginsOf(job.machine(), job.job()).size() == 1;
}

/// At the machine's own limits, which a speed override may use. The plan itself becomes
/// what the bound is computed from.
void AddBound(const Evidence& evidence, PointList plan_mm, JobReport& report) {
  const FrozenJob& job = evidence.job;
  motion::PlanOptions plan;
  plan.limits = AxisLimitsOf(job.machine());
  plan.rate_hz = job.job().laser().rate_hz();
  plan.tolerance_mm =
      AxisToleranceOf(job, 1e-3 * report.position_errors().allowed_move_um());
  auto axes =
      machine::AxesAlong(AxesFromGlassOf(job), std::move(plan_mm), plan.limits.travel_mm);
  if (!axes) return;
  const auto bound =
      JobTicksBound(job.machine(), *std::move(axes), plan, host::AllCores());
  if (bound) report.set_ticks_bound(*bound);
}

/// The plan's own positions in the order in which they were made: the deviation of a
/// crack does not depend on the order.
void AddOrder(const Evidence& evidence, const MadeOrder& order, JobReport& report) {
  report.set_shadow_violations(sort::CountShadowViolations(
      evidence.plan_mm, evidence.masks, order.points, PointConeOf(evidence.job)));
  if (order.ticks == 0) return;
  report.set_ticks(order.ticks);
  report.set_utilisation(static_cast<double>(order.points.size()) /
                         static_cast<double>(order.ticks));
  report.set_machining_time_s(static_cast<double>(order.ticks) /
                              report.job().laser().rate_hz());
}

/// Releases the plan with the glass: the pictures show the cracks.
void AddPlan(Evidence& evidence, JobReport& report) {
  const bool has_bound = HasBound(evidence, report);
  if (evidence.plan_mm.size() > 1) {
    report.set_measured_spacing_mm(
        proof::MinSpacing(evidence.plan_mm, evidence.masks, host::AllCores()));
    host::ReturnFreedMemory();
  }
  (*report.mutable_checksums())["path"] = PointChecksum(evidence.plan_mm);
  if (!evidence.has_glass) {
    if (has_bound) AddBound(evidence, evidence.plan_mm, report);
    return;
  }
  evidence.masks = {};
  PointList plan_mm = std::exchange(evidence.plan_mm, {});
  if (has_bound) AddBound(evidence, std::move(plan_mm), report);
}

}  // namespace

JobReport FiguresOf(Evidence& evidence) {
  JobReport report;
  const FrozenJob& frozen = evidence.job;
  report.set_job_uid(frozen.job_uid());
  report.set_name(frozen.job().name());
  report.set_software_version(frozen.software_version());
  *report.mutable_job() = frozen.job();
  *report.mutable_machine() = frozen.machine();
  report.set_station(frozen.job().station());
  *report.mutable_material() = frozen.material();
  *report.mutable_optics() = frozen.optics();
  report.set_evidence(evidence.has_glass ? kGlassEvidence : kControllerEvidence);
  report.set_min_spacing_mm(frozen.job().discretization().min_spacing_mm());
  PositionErrors& errors = *report.mutable_position_errors();
  errors.set_tolerance_um(frozen.machine().position_tolerance_um());
  if (frozen.job().motion().profile() == MOTION_PROFILE_CONTINUOUS) {
    errors.set_allowed_move_um(frozen.job().motion().tolerance_um() +
                               frozen.job().motion().depth_tolerance_um());
  }
  *report.mutable_collisions() = evidence.collisions.collisions();
  AddPulseEnergies(evidence.history, std::exchange(evidence.energies, {}), report);
  AddMisses(evidence.history, report);
  CountPulses(evidence.history, std::max(1U, frozen.job().laser().pulses_per_point()),
              report);
  AddOrder(evidence,
           evidence.has_glass ? MeasureGlass(evidence, report)
                              : CountByController(evidence, report),
           report);
  if (evidence.has_glass) AddCracks(evidence.cracks, report);
  AddPlan(evidence, report);
  return report;
}

std::string PointChecksum(const PointList& points_mm) {
  return fmt::format("{:08x}", formats::PathCrc(points_mm));
}

}  // namespace intaglio::client
