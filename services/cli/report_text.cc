#include "services/cli/report_text.h"

#include <fmt/format.h>

#include "services/client/figure_text.h"

namespace intaglio::cli {

std::string SummaryOf(const JobReport& report) {
  const PointCounts& points = report.points();
  std::string text = fmt::format(
      "points      {} planned, {} made, {} skipped, {} missed, {} doubled, {} stray\n"
      "order       {} points fired through an earlier crack\n"
      "spacing     {:.4f} mm minimum, {:.4f} mm required\n"
      "position    {:.2f} um rms, {:.2f} um max, tolerance {:.2f} um\n"
      "time        {} at {:g} Hz, {} ticks, {:.4f} points a tick\n",
      client::GroupedDigits(points.planned()), client::GroupedDigits(points.made()),
      client::GroupedDigits(points.skipped()), client::GroupedDigits(points.missed()),
      client::GroupedDigits(points.doubled()), client::GroupedDigits(points.stray()),
      report.shadow_violations(), report.measured_spacing_mm(), report.min_spacing_mm(),
      report.position_errors().rms_um(), report.position_errors().max_um(),
      report.position_errors().tolerance_um(),
      client::ShortDuration(report.machining_time_s()), report.job().laser().rate_hz(),
      client::GroupedDigits(report.ticks()), report.utilisation());
  for (const ChannelCounts& channel : report.channels()) {
    text += fmt::format(
        "channel {}   {} planned, {} made, {} doubled, {} stray\n", channel.channel(),
        client::GroupedDigits(channel.planned()), client::GroupedDigits(channel.made()),
        client::GroupedDigits(channel.doubled()), client::GroupedDigits(channel.stray()));
  }
  if (report.position_errors().allowed_move_um() > 0) {
    text += fmt::format(
        "moves       {:.2f} um allowed, {:.2f} um maximum of the plan, {:.2f} um rms\n",
        report.position_errors().allowed_move_um(),
        report.engrave().planned_max_move_um(), report.engrave().planned_rms_move_um());
  }
  if (report.verdict().good()) return text + "verdict     GOOD";
  text += "verdict     NOT GOOD";
  for (const std::string& reason : report.verdict().reasons()) text += "\n  - " + reason;
  return text;
}

}  // namespace intaglio::cli
