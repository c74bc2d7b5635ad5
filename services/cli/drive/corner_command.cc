// `intaglio drive corner`: what two axes make of a corner that is passed at constant
// speed, by the published formulas and exactly. Zarudnev 2007, (4)-(8) and figure 2.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/course/corner_response.h"
#include "engrave/course/source_law.h"
#include "engrave/io/atomic_file.h"
#include "engrave/render/chart.h"
#include "engrave/render/png_file.h"
#include "services/cli/drive/drive_command.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"

namespace intaglio::cli {
namespace {

// Figure 2 has w1 in steps, up to what the source draws.
constexpr int kFirstNatural = 40, kLastNatural = 200, kNaturalStep = 5;
constexpr double kRadPerDeg = std::numbers::pi / 180;

struct DriveCornerOptions {
  double natural_x_rad_s = 150, natural_y_rad_s = 220;
  double damping_ratio = 0.3, turn_deg = 90, speed_mm_s = 100, tolerance_um = 100;
  bool cascade = false;
  std::vector<double> figure_rad_s;
  std::string csv, picture;
};

course::AxisPair AxesOf(const DriveCornerOptions& o, double natural_x_rad_s,
                        double natural_y_rad_s) {
  return course::TunedAxes(
      natural_x_rad_s, natural_y_rad_s, o.damping_ratio, o.damping_ratio,
      o.cascade ? course::LoopKind::kCascade : course::LoopKind::kFirstOrder);
}

/// With the first leg along this direction; the worse of a turn to either side.
course::CornerError CornerFrom(const course::AxisPair& axes, double first_rad,
                               double turn_rad) {
  const auto direction = [](double angle_rad) {
    return Vec2(std::cos(angle_rad), std::sin(angle_rad));
  };
  course::CornerError worse;
  for (const double side : {-1.0, 1.0}) {
    const auto error = course::CornerResponse(axes, direction(first_rad),
                                              direction(first_rad + side * turn_rad));
    worse.one_sided_s = std::max(worse.one_sided_s, error.one_sided_s);
    worse.node_miss_s = std::max(worse.node_miss_s, error.node_miss_s);
  }
  return worse;
}

course::CornerError WorseOrder(const course::AxisPair& axes, double turn_rad) {
  const auto x = CornerFrom(axes, 0, turn_rad);
  const auto y = CornerFrom(axes, std::numbers::pi / 2, turn_rad);
  return {std::max(x.one_sided_s, y.one_sided_s), std::max(x.node_miss_s, y.node_miss_s)};
}

double FormulaS(const DriveCornerOptions& o, double natural_x_rad_s,
                double natural_y_rad_s) {
  return course::SourceCornerError(kRadPerDeg * o.turn_deg, o.damping_ratio,
                                   natural_x_rad_s, natural_y_rad_s);
}

std::string ErrorLine(const char* name, const course::CornerError& error,
                      double speed_mm_s) {
  return fmt::format(
      "{:<14}{:.5g} ms beside the path, {:.5g} ms at the corner: {:.1f} "
      "and {:.1f} um at {:g} mm/s\n",
      name, 1e3 * error.one_sided_s, 1e3 * error.node_miss_s,
      1e3 * speed_mm_s * error.one_sided_s, 1e3 * speed_mm_s * error.node_miss_s,
      speed_mm_s);
}

std::string LawLine(const char* name, double allowance_ratio, double formula_s,
                    const course::CornerError& exact, double tolerance_um) {
  const double speed_mm_s = allowance_ratio * tolerance_um / 1e3 / formula_s;
  const double error_um = 1e3 * speed_mm_s * exact.worst_s();
  return fmt::format("{:<14}{:.4g} mm/s for {:g} um: {:.1f} um exactly, {}\n", name,
                     speed_mm_s, tolerance_um, error_um,
                     error_um <= tolerance_um ? "held" : "NOT held");
}

void PrintCorner(const DriveCornerOptions& o) {
  const auto axes = AxesOf(o, o.natural_x_rad_s, o.natural_y_rad_s);
  const double turn_rad = kRadPerDeg * o.turn_deg;
  const auto x_first = CornerFrom(axes, 0, turn_rad);
  const auto y_first = CornerFrom(axes, std::numbers::pi / 2, turn_rad);
  const auto worse = WorseOrder(axes, turn_rad);
  const double formula_s = FormulaS(o, o.natural_x_rad_s, o.natural_y_rad_s);
  std::cout << fmt::format(
      "rule (4)      bandwidth {:.5g} rad/s of both axes; lags {:.5g} ms of x, {:.5g} ms "
      "of y\n"
      "formula (6)   {:.5g} ms: {:.1f} um at {:g} mm/s, {:+.0f} % beside exact\n",
      axes[0].parameters().bandwidth_rad_s, 1e3 * axes[0].lag_s(), 1e3 * axes[1].lag_s(),
      1e3 * formula_s, 1e3 * o.speed_mm_s * formula_s, o.speed_mm_s,
      100 * (formula_s / worse.one_sided_s - 1));
  std::cout << ErrorLine("x first", x_first, o.speed_mm_s)
            << ErrorLine("y first", y_first, o.speed_mm_s)
            << LawLine("published", 1, formula_s, worse, o.tolerance_um)
            << LawLine("0.45 of it", course::kSourceAllowanceRatio, formula_s, worse,
                       o.tolerance_um)
            << fmt::format("{:<14}{:.4g} mm/s for {:g} um in both orders\n", "exact",
                           o.tolerance_um / 1e3 / worse.worst_s(), o.tolerance_um);
}

/// Figure 2: one row for each w1, exact in the worse order of axes.
struct FigureRow {
  double natural_1_rad_s, natural_2_rad_s, exact_um, formula_um;
};

std::vector<FigureRow> FigureOf(const DriveCornerOptions& o, double natural_2_rad_s) {
  std::vector<FigureRow> rows;
  for (int w1 = kFirstNatural; w1 <= kLastNatural; w1 += kNaturalStep) {
    const auto axes = AxesOf(o, w1, natural_2_rad_s);
    const double um_per_s = 1e3 * o.speed_mm_s;
    rows.push_back({static_cast<double>(w1), natural_2_rad_s,
                    um_per_s * WorseOrder(axes, kRadPerDeg * o.turn_deg).one_sided_s,
                    um_per_s * FormulaS(o, w1, natural_2_rad_s)});
  }
  return rows;
}

Status WriteFigure(const DriveCornerOptions& o) {
  std::string table = "w1_rad_s,w2_rad_s,exact_um,formula_um\n";
  std::vector<render::Curve> curves;
  for (const double natural_2_rad_s : o.figure_rad_s) {
    render::Curve exact{fmt::format("exact, w2 {:g}", natural_2_rad_s), {}};
    render::Curve formula{fmt::format("formula, w2 {:g}", natural_2_rad_s), {}};
    for (const FigureRow& row : FigureOf(o, natural_2_rad_s)) {
      table += fmt::format("{:g},{:g},{:.2f},{:.2f}\n", row.natural_1_rad_s,
                           row.natural_2_rad_s, row.exact_um, row.formula_um);
      exact.points.emplace_back(row.natural_1_rad_s, row.exact_um);
      formula.points.emplace_back(row.natural_1_rad_s, row.formula_um);
    }
    curves.push_back(std::move(exact));
    curves.push_back(std::move(formula));
  }
  if (!o.csv.empty())
    INTAGLIO_TRY(io::WriteFileAtomically(o.csv, std::string_view(table)));
  if (o.csv.empty() && o.picture.empty()) std::cout << table;
  if (o.picture.empty()) return {};
  const render::ChartOptions chart{
      fmt::format("Corner of {:g} degrees at {:g} mm/s, damping {:g}", o.turn_deg,
                  o.speed_mm_s, o.damping_ratio),
      "natural frequency of the first axis, rad/s", "error beside the path, um"};
  return render::WritePng(o.picture, render::DrawChart(curves, chart));
}

int Corner(const DriveCornerOptions& o) {
  if (o.figure_rad_s.empty()) {
    PrintCorner(o);
    return client::kExitGood;
  }
  const auto written = WriteFigure(o);
  if (!written) return Complain(written.error(), client::kExitWrongInput);
  return client::kExitGood;
}

}  // namespace

void AddDriveCornerCommand(command_line::Command drive) {
  auto o = std::make_shared<DriveCornerOptions>();
  command_line::Command corner = drive.AddCommand(
      "corner", "the error of two axes at a corner: published formulas and exact");
  corner
      .AddOption("--wx", o->natural_x_rad_s,
                 "natural frequency of x, rad/s (10 to 100000)")
      .Within(10.0, 1e5)
      .ShowDefault();
  corner.AddOption("--wy", o->natural_y_rad_s, "of y, rad/s")
      .Within(10.0, 1e5)
      .ShowDefault();
  corner.AddOption("--damping", o->damping_ratio, "of both axes (0.01..5)")
      .Within(0.01, 5.0)
      .ShowDefault();
  corner.AddOption("--turn", o->turn_deg, "of the corner, degrees (1..179)")
      .Within(1.0, 179.0)
      .ShowDefault();
  corner.AddOption("--speed", o->speed_mm_s, "through the corner, mm/s")
      .Positive()
      .ShowDefault();
  corner.AddOption("--tolerance", o->tolerance_um, "for which the laws give a speed, um")
      .Positive()
      .ShowDefault();
  corner.AddFlag("--cascade", o->cascade,
                 "loops whose bandwidths are as 12 : 3 : 1, in place of the first order "
                 "of the source");
  corner
      .AddOption("--figure", o->figure_rad_s,
                 "figure 2: errors over the first axis' frequency, for these of the "
                 "second, rad/s; a table")
      .TakeValues(1, 3);
  corner.AddOption("--csv", o->csv, "of the figure, a table");
  corner.AddOption("--picture", o->picture, "of the figure, PNG");
  corner.SetFooter(
      "Example: intaglio drive corner --wx 150 --wy 220 --damping 0.3 --turn 90\n"
      "Example: intaglio drive corner --figure 55 105 --picture figure2.png\n"
      "Exit code: 0 good, 2 wrong input.");
  corner.SetAction([o] { return Corner(*o); });
}

}  // namespace intaglio::cli
