#include "services/client/proof/proof_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "engrave/core/channels.h"
#include "engrave/formats/journal_file.h"
#include "engrave/machine/axes_from_glass.h"
#include "engrave/proof/glass_comparison.h"
#include "engrave/sort/shadow.h"
#include "services/client/proof/pulse_figures.h"
#include "services/job/convert/options.h"
#include "services/job/machine/block_origin.h"
#include "services/job/machine/job_ticks_bound.h"
#include "services/job/machine/machine_axes.h"

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

void Count(const Evidence& evidence, const proof::GlassComparison& glass,
           PointCounts& counts) {
  counts.set_planned(glass.planned_count);
  counts.set_made(glass.made_count);
  counts.set_doubled(glass.doubled_count);
  counts.set_stray(glass.stray_count + evidence.cracks_elsewhere_count);
  std::uint64_t skipped = 0, missed = 0, unaccounted = 0;
  for (std::size_t i = 0; i < evidence.plan_mm.size(); ++i) {
    const PointHistory& journaled = evidence.history[i];
    const bool crack = glass.cracks_of_point[i] > 0;
    const bool made = journaled.outcome == PointOutcome::kMade;
    if (crack && made) continue;
    if (!crack && WasNeverTried(journaled)) {
      ++skipped;
    } else if (!crack && journaled.outcome == PointOutcome::kMissed) {
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

void AddGlass(const Evidence& evidence, const proof::GlassComparison& glass,
              JobReport& report) {
  Count(evidence, glass, *report.mutable_points());
  AddChannels(glass, evidence.masks, report);
  PositionErrors& errors = *report.mutable_position_errors();
  errors.set_rms_um(glass.errors.rms_um);
  errors.set_max_um(glass.errors.max_um);
  errors.set_rms_x_um(glass.errors.axis_rms_um.x());
  errors.set_rms_y_um(glass.errors.axis_rms_um.y());
  errors.set_rms_z_um(glass.errors.axis_rms_um.z());
  PointList cracks_mm;
  std::vector<ChannelMask> crack_channels;
  cracks_mm.reserve(evidence.cracks.size());
  crack_channels.reserve(evidence.cracks.size());
  for (const proof::Crack& crack : evidence.cracks) {
    cracks_mm.push_back(crack.position_mm);
    crack_channels.push_back(crack.channel);
  }
  if (cracks_mm.size() > 1) {
    report.set_measured_spacing_in_glass_mm(proof::MinSpacing(cracks_mm, crack_channels));
  }
  (*report.mutable_checksums())["glass"] = PointChecksum(cracks_mm);
}

MadeOrder MeasureGlass(const Evidence& evidence, JobReport& report) {
  auto glass = proof::CompareGlass(evidence.plan_mm, evidence.masks, evidence.cracks,
                                   report.min_spacing_mm() / 2);
  AddGlass(evidence, glass, report);
  return {std::move(glass.made_order),
          evidence.cracks.empty() ? 0 : glass.last_tick - glass.first_tick + 1};
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

/// At the machine's own limits, which a speed override may use.
void AddBound(const Evidence& evidence, JobReport& report) {
  if (!HasBound(evidence, report)) return;
  const FrozenJob& job = evidence.job;
  motion::PlanOptions plan;
  plan.limits = AxisLimitsOf(job.machine());
  plan.rate_hz = job.job().laser().rate_hz();
  plan.tolerance_mm =
      AxisToleranceOf(job, 1e-3 * report.position_errors().allowed_move_um());
  const auto axes =
      machine::AxesAlong(AxesFromGlassOf(job), evidence.plan_mm, plan.limits.travel_mm);
  if (!axes) return;
  const auto bound = JobTicksBound(job.machine(), *axes, plan);
  if (bound) report.set_ticks_bound(*bound);
}

void AddOrder(const Evidence& evidence, const MadeOrder& order, JobReport& report) {
  // The plan's own positions in the order in which they were made: the deviation of a
  // crack does not depend on the order.
  PointList made_mm;
  std::vector<ChannelMask> made_masks;
  made_mm.reserve(order.points.size());
  made_masks.reserve(order.points.size());
  for (const std::uint32_t point : order.points) {
    made_mm.push_back(evidence.plan_mm[point]);
    made_masks.push_back(evidence.masks[point]);
  }
  report.set_shadow_violations(
      sort::CountShadowViolations(made_mm, made_masks, PointConeOf(evidence.job)));
  if (order.ticks == 0) return;
  report.set_ticks(order.ticks);
  report.set_utilisation(static_cast<double>(order.points.size()) /
                         static_cast<double>(order.ticks));
  report.set_machining_time_s(static_cast<double>(order.ticks) /
                              report.job().laser().rate_hz());
}

}  // namespace

JobReport FiguresOf(const Evidence& evidence) {
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
  AddOrder(evidence,
           evidence.has_glass ? MeasureGlass(evidence, report)
                              : CountByController(evidence, report),
           report);
  AddBound(evidence, report);
  *report.mutable_collisions() = evidence.collisions.collisions();
  AddPulseEnergies(evidence.history, evidence.energies, report);
  AddMisses(evidence.history, report);
  if (evidence.plan_mm.size() > 1) {
    report.set_measured_spacing_mm(proof::MinSpacing(evidence.plan_mm, evidence.masks));
  }
  (*report.mutable_checksums())["path"] = PointChecksum(evidence.plan_mm);
  return report;
}

std::string PointChecksum(const PointList& points_mm) {
  return fmt::format("{:08x}", formats::PathCrc(points_mm));
}

}  // namespace intaglio::client
