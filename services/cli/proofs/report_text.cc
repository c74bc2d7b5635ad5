#include "services/cli/proofs/report_text.h"

#include <fmt/format.h>

#include "engrave/core/counted.h"
#include "services/cli/proofs/mark_text.h"
#include "services/client/figure_text.h"
#include "services/client/proof/evidence/proof_figures.h"
#include "services/client/proof/evidence/verdict_text.h"
#include "services/job/machine/stations.h"

namespace intaglio::cli {

namespace {

using client::GroupedDigits;

/// What only the glass can show, or what is known without it.
std::string PointsText(const JobReport& report) {
  const PointCounts& points = report.points();
  std::string text =
      fmt::format("points      {} planned, {} made, {} skipped, {} missed, ",
                  GroupedDigits(points.planned()), GroupedDigits(points.made()),
                  GroupedDigits(points.skipped()), GroupedDigits(points.missed()));
  if (report.evidence() == client::kControllerEvidence) {
    return text + fmt::format(
                      "{} uncertain\nevidence    the laser controller's counters; "
                      "the glass was not measured\n",
                      GroupedDigits(points.unaccounted()));
  }
  const PositionErrors& errors = report.position_errors();
  return text + fmt::format(
                    "{} doubled, {} stray\n"
                    "position    {:.2f} um rms, {:.2f} um max, tolerance {:.2f} um\n",
                    GroupedDigits(points.doubled()), GroupedDigits(points.stray()),
                    errors.rms_um(), errors.max_um(), errors.tolerance_um());
}

/// As `intaglio plan` prints it.
std::string PredictionText(const JobReport& report) {
  const EngraveOutcome& engrave = report.engrave();
  if (!engrave.has_predicted_max_error_um()) return "";
  const double margin_um = engrave.wrong_mechanics_max_error_um();
  const double tolerance_um = report.position_errors().tolerance_um();
  return fmt::format(
      "predicted   {:.2f} um rms, {:.2f} um max; with mechanics 5 % off in frequency or "
      "20 % in damping {:.2f} um, {} the tolerance\n",
      engrave.predicted_rms_error_um(), engrave.predicted_max_error_um(), margin_um,
      margin_um <= tolerance_um ? "within" : "BEYOND");
}

std::string EnergyText(const PulseEnergyReport& energy) {
  std::string text = fmt::format("energy      {:g} mJ commanded", energy.commanded_mj());
  if (energy.measured_count() == 0) return text + ", not measured by the laser\n";
  return text + fmt::format(
                    "; measured {:.4g} mJ mean, {:.2g} mJ spread, {:.4g} mJ furthest "
                    "off (point {})\n",
                    energy.mean_mj(), energy.spread_mj(), energy.furthest_mj(),
                    energy.furthest_point());
}

std::string PulsesText(const JobReport& report) {
  std::string text;
  if (report.has_pulse_energy()) text += EnergyText(report.pulse_energy());
  for (const PulseEnergyReport& energy : report.pulse_energies())
    text += EnergyText(energy);
  if (report.pulses_per_point() > 1) {
    text += fmt::format("pulses      {}, {} a point\n",
                        GroupedDigits(report.pulse_count()), report.pulses_per_point());
  }
  for (const ChannelMisses& misses : report.missed_by_channel()) {
    text += fmt::format("missed      {} by channel {}\n", GroupedDigits(misses.count()),
                        misses.channel());
  }
  return text;
}

/// What the glass holds, and how it was made.
std::string GlassLines(const JobReport& report) {
  std::string text;
  if (report.station() > 0) {
    text += fmt::format("station     {} of {}\n", report.station(),
                        StationCountOf(report.machine()));
  }
  text += PointsText(report);
  text += fmt::format(
      "order       {} fired through an earlier crack\n"
      "spacing     minimum {}, {:.4f} mm required\n"
      "time        {} at {:g} Hz, {}{}, {:.4f} points a tick\n",
      client::GroupedCount(report.shadow_violations(), "point"),
      client::SpacingText(report), report.min_spacing_mm(),
      client::ShortDuration(report.machining_time_s()), report.job().laser().rate_hz(),
      client::GroupedCount(report.ticks(), "tick"),
      report.has_ticks_bound() ? client::AboveBound(report.ticks(), report.ticks_bound())
                               : "",
      report.utilisation());
  text += PulsesText(report);
  for (const ChannelCounts& channel : report.channels()) {
    text += fmt::format("channel {}   {} planned, {} made, {} doubled, {} stray\n",
                        channel.channel(), GroupedDigits(channel.planned()),
                        GroupedDigits(channel.made()), GroupedDigits(channel.doubled()),
                        GroupedDigits(channel.stray()));
  }
  if (report.position_errors().allowed_move_um() > 0) {
    text += fmt::format(
        "moves       {:.2f} um allowed, {:.2f} um maximum of the plan, {:.2f} um rms\n",
        report.position_errors().allowed_move_um(),
        report.engrave().planned_max_move_um(), report.engrave().planned_rms_move_um());
  }
  return text + PredictionText(report);
}

}  // namespace

std::string SummaryOf(const JobReport& report) {
  std::string text = report.has_marks() ? MarkLines(report) : GlassLines(report);
  text += "verdict     " + client::VerdictTitle(report.verdict(), "GOOD");
  for (const std::string& reason : report.verdict().reasons()) text += "\n  - " + reason;
  return text;
}

}  // namespace intaglio::cli
