#include "services/cli/machine/measurement_text.h"

#include <fmt/format.h>

#include "engrave/core/counted.h"

namespace intaglio::cli {
namespace {

std::string TextOf(const MeasuredFigure& figure, double unit, int decimals) {
  return fmt::format("{:.{}f} +- {:.{}f}", unit * figure.value(), decimals,
                     unit * figure.interval95(), decimals);
}

std::vector<std::string> HeadLinesOf(const MachineMeasurement& report) {
  std::vector<std::string> lines = {
      fmt::format("marks          {} measured, {} left out", report.measured_count(),
                  report.measured_count() - report.matched_count()),
      fmt::format("deviation      rms {:.1f} um, largest {:.1f} um; {:.1f} um in each "
                  "coordinate would be left after correction",
                  report.rms_deviation_um(), report.max_deviation_um(),
                  report.rms_residual_um())};
  for (const MeasuredHeadFigure& figure : report.head()) {
    std::string text =
        fmt::format("{:<14} {:.6f}", figure.name(), figure.figure().value());
    if (figure.figure().interval95() > 0)
      text += fmt::format(" +- {:.6f}", figure.figure().interval95());
    if (!figure.unit().empty()) text += " " + figure.unit();
    lines.push_back(text + ", " + figure.state());
  }
  return lines;
}

}  // namespace

std::vector<std::string> FigureLinesOf(const MachineMeasurement& report) {
  if (report.head_size() > 0) return HeadLinesOf(report);
  std::vector<std::string> lines = {
      fmt::format("marks          {} measured, {} of the {} of the pattern",
                  report.measured_count(), report.matched_count(),
                  report.pattern_count()),
      fmt::format("deviation      rms {:.1f} um, largest {:.1f} um; {:.1f} um would be "
                  "left after correction",
                  report.rms_deviation_um(), report.max_deviation_um(),
                  report.rms_residual_um())};
  for (const MeasuredAxis& axis : report.axes()) {
    lines.push_back(fmt::format(
        "{}              scale {}, backlash {} um, lag {} us, repeatability {} um; {}, "
        "{} left out",
        axis.axis(), TextOf(axis.scale_ratio(), 1, 6), TextOf(axis.backlash_um(), 1, 1),
        TextOf(axis.lag_us(), 1, 0), TextOf(axis.repeatability_um(), 1, 1),
        Counted(axis.used_count(), "mark"), axis.rejected_count()));
  }
  lines.push_back(fmt::format("squareness     {} mrad less than a right angle",
                              TextOf(report.squareness_xy_rad(), 1000, 3)));
  return lines;
}

std::vector<std::string> OutcomeLinesOf(const MachineMeasurement& report) {
  std::vector<std::string> lines;
  for (const std::string& text : report.corrections()) {
    lines.push_back("correction     " + text);
  }
  if (lines.empty()) lines.push_back("correction     none: the profile is right");
  for (const std::string& text : report.remarks()) {
    lines.push_back("to do          " + text);
  }
  lines.push_back("profile        " + report.profile());
  lines.push_back("picture        " + report.picture());
  return lines;
}

}  // namespace intaglio::cli
