#include "services/client/preview/preview_text.h"

#include <fmt/format.h>

#include "engrave/core/counted.h"
#include "engrave/core/warning.h"
#include "services/client/figure_text.h"
#include "services/job/quality/pulse_focus.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::client {
namespace {

std::string PlainSizeText(const Vector3& size_mm) {
  return fmt::format("{:g} x {:g} x {:g} mm", size_mm.x(), size_mm.y(), size_mm.z());
}

/// The time of a head that jumps and dwells, by part.
std::string JumpTimeText(const TimePreview& time) {
  const JumpTimePreview& parts = time.jumps();
  std::string text =
      fmt::format("{}: jumps {}, delays {}, dwell {}, {} of z {}",
                  ShortDuration(time.machining_time_s()), ShortDuration(parts.jump_s()),
                  ShortDuration(parts.delay_s()), ShortDuration(parts.dwell_s()),
                  GroupedCount(parts.z_move_count(), "move"), ShortDuration(parts.z_s()));
  if (parts.pause_s() > 0)
    text += fmt::format(", pauses {}", ShortDuration(parts.pause_s()));
  text += fmt::format("; {} a point, {}", GroupedCount(parts.pulses_per_point(), "pulse"),
                      GroupedCount(parts.list_count(), "list"));
  if (parts.energy_change_count() > 0) {
    text += fmt::format(", {} of energy within layers",
                        GroupedCount(parts.energy_change_count(), "change"));
  }
  return text;
}

std::string TimeText(const JobPreview& figures) {
  const TimePreview& time = figures.time();
  if (time.has_jumps()) return JumpTimeText(time);
  std::string text = fmt::format(
      "{}{} at {:g} Hz", time.planned_count() < figures.point_count() ? "about " : "",
      ShortDuration(time.machining_time_s()), time.rate_hz());
  if (time.warm_up_s() > 0) {
    text += fmt::format(", after {} of lamp warm-up", ShortDuration(time.warm_up_s()));
  }
  if (time.has_ticks_bound()) {
    text += fmt::format("; {}{}", GroupedCount(time.ticks(), "tick"),
                        AboveBound(time.ticks(), time.ticks_bound()));
  }
  if (time.planned_count() < figures.point_count()) {
    text +=
        fmt::format("; from a sample of {}", GroupedCount(time.planned_count(), "point"));
  }
  text += fmt::format("; {:.3f} points a tick", time.utilisation());
  return text;
}

std::string PointsText(const JobPreview& figures) {
  if (figures.verdict() == kDraft) {
    return fmt::format("about {} ({:g} mm required)",
                       GroupedDigits(figures.point_count()), figures.min_spacing_mm());
  }
  std::string text = GroupedDigits(figures.point_count());
  if (figures.measured_spacing_mm() > 0) {
    text += fmt::format(", nearest two {:.4g} mm apart", figures.measured_spacing_mm());
  }
  return text + fmt::format(" ({:g} mm required)", figures.min_spacing_mm());
}

std::string BreakageText(const BreakagePreview& breakage) {
  const std::string share =
      fmt::format("cracks take {:.0f} % of the densest place, {:.0f} % are sound",
                  100 * breakage.crack_share_ratio(), 100 * breakage.max_share_ratio());
  if (breakage.risky_count() == 0) return share;
  return fmt::format("may break: {}; more at {}", share,
                     GroupedCount(breakage.risky_count(), "point"));
}

std::string EnergyText(const ObliquePreview& oblique) {
  if (!oblique.energy_by_place())
    return "the energy does not follow the place: " + oblique.why_one_energy();
  std::string text =
      fmt::format("energy by place, {:.3g}..{:.3g} mJ in {}", oblique.min_energy_mj(),
                  oblique.max_energy_mj(), Counted(oblique.energy_count(), "step"));
  if (oblique.limited_count() > 0) {
    text += fmt::format("; {} {} weaker than asked for, since the laser has no more",
                        GroupedCount(oblique.limited_count(), "point"),
                        IsOrAre(oblique.limited_count()));
  }
  return text;
}

/// By depth, how far from the axis of the lens there are cracks.
std::string ObliqueText(const ObliquePreview& oblique) {
  std::string text = "cracks";
  const char* before = " ";
  for (const UsableRadius& at : oblique.radii()) {
    text += fmt::format("{}up to {:.1f} mm from the axis at {:.0f} mm depth", before,
                        at.radius_mm(), at.depth_mm());
    before = ", ";
  }
  text +=
      fmt::format("; the weakest point has {:.2f} of the intensity and needs {:.3g} mJ",
                  oblique.weakest_ratio(), oblique.needed_energy_mj());
  if (oblique.weak_count() > 0)
    text +=
        fmt::format("; {} without a crack", GroupedCount(oblique.weak_count(), "point"));
  return text + "; " + EnergyText(oblique);
}

std::string GlassText(const JobPreview& figures) {
  std::string text = figures.glass();
  if (figures.has_local_thermal_strength_k()) {
    text += fmt::format(", withstands a sudden local heating by {:.0f} K",
                        figures.local_thermal_strength_k());
  } else {
    text += ", thermal strength not known";
  }
  if (figures.has_light()) {
    text += fmt::format(", {:.0f} % of the light arrive at the deepest point",
                        100 * figures.light().deepest_ratio());
  }
  return text;
}

}  // namespace

std::string VerdictText(const JobPreview& figures) {
  if (figures.verdict() == kReady) return "READY";
  if (figures.verdict() == kReadyWithWarnings) return "READY, with warnings";
  if (figures.verdict() == kDraft) {
    return fmt::format("DRAFT of {}; the preview follows",
                       GroupedCount(figures.draft_count(), "point"));
  }
  const Warnings warnings = WarningsOf(figures.warnings());
  const Warning* consent = FindConsent(warnings);
  return fmt::format("NOT READY: arm it with {} if you accept what may happen",
                     consent == nullptr ? "a consent" : AcceptOption(*consent));
}

std::string SizeText(const Vector3& size_mm) {
  return fmt::format("{:.1f} x {:.1f} x {:.1f} mm", size_mm.x(), size_mm.y(),
                     size_mm.z());
}

namespace {

std::vector<PreviewLine> CourseLines(const JobPreview& figures) {
  const CoursePreview& course = figures.course();
  return {{"contours",
           fmt::format("{}, {:.1f} mm with a tool of {:g} mm; {}; {:.1f} mm between",
                       GroupedDigits(course.contour_count()), course.work_mm(),
                       course.tool_diameter_mm(),
                       GroupedCount(course.hole_count(), "hole"), course.idle_mm())},
          {"time",
           fmt::format("{}: {} at work, {} between, {} drilling; without acceleration",
                       ShortDuration(figures.time().machining_time_s()),
                       ShortDuration(course.work_s()), ShortDuration(course.idle_s()),
                       ShortDuration(course.drill_s()))},
          {"machine", figures.machine()}};
}

}  // namespace

std::vector<PreviewLine> LinesOf(const JobPreview& figures) {
  if (figures.has_course()) return CourseLines(figures);
  const Vector3& low = figures.low_mm();
  std::vector<PreviewLine> lines = {
      {"piece", SizeText(figures.size_mm())},
      {"block", fmt::format("{}, margin {:g} mm; the piece begins at ({:.1f}, {:.1f}, "
                            "{:.1f}) mm",
                            PlainSizeText(figures.block_size_mm()), figures.margin_mm(),
                            low.x(), low.y(), low.z())},
      {"points", PointsText(figures)}};
  if (figures.verdict() == kDraft) return lines;
  lines.push_back({"time", TimeText(figures)});
  lines.push_back({"glass", GlassText(figures)});
  lines.push_back({"machine", figures.machine()});
  if (figures.has_pulse()) {
    const std::string& condition = figures.pulse().condition();
    lines.push_back(
        {"pulse",
         fmt::format("{:g} mJ at {}, condition of a crack {}",
                     figures.pulse().pulse_energy_mj(), figures.pulse().lens(),
                     CrackConditionText(figures.pulse())),
         condition == kPulseTooWeak || condition == kPulseMelts});
  }
  if (figures.has_oblique()) {
    lines.push_back(
        {"beam", ObliqueText(figures.oblique()), figures.oblique().weak_count() > 0});
  }
  if (figures.has_breakage()) {
    lines.push_back({"breakage", BreakageText(figures.breakage()),
                     figures.breakage().risky_count() > 0});
  }
  for (const ChannelPreview& channel : figures.channels()) {
    lines.push_back({fmt::format("channel {}", channel.channel()),
                     GroupedCount(channel.point_count(), "point")});
  }
  return lines;
}

}  // namespace intaglio::client
