// `intaglio drive circle`: a measured circle as ISO 230-4 evaluates it.

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engrave/calibrate/circle_check.h"
#include "engrave/core/try.h"
#include "engrave/io/csv.h"
#include "engrave/io/number_text.h"
#include "services/cli/drive/drive_command.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"

namespace intaglio::cli {
namespace {

struct DriveCircleOptions {
  std::string table, clockwise;
  double radius_mm = 0;
  std::optional<double> feed_mm_s;
  std::vector<double> centre_mm;
  std::optional<double> tolerance_um;
};

Result<std::vector<Vec2>> ReadCirclePoints(const std::string& file) {
  const auto table = INTAGLIO_TRY(io::ReadCsv(file));
  std::vector<Vec2> points;
  for (const io::CsvRow& row : table.rows) {
    Vec2 point;
    for (const int axis : {0, 1}) {
      const char* column = axis == 0 ? "x_mm" : "y_mm";
      const std::string* text = table.Find(row, column);
      const auto number = text == nullptr ? std::nullopt : io::ParseFinite(*text);
      if (!number) {
        return Fail(ErrorCode::kInvalidValue,
                    fmt::format("{}:{}: {} is no number or is missing; give the columns "
                                "x_mm and y_mm",
                                file, row.line_number, column));
      }
      point[axis] = *number;
    }
    points.push_back(point);
  }
  return points;
}

Result<calibrate::CircleCheck> CheckOf(const DriveCircleOptions& o,
                                       const std::string& file) {
  const auto points = INTAGLIO_TRY(ReadCirclePoints(file));
  std::optional<Vec2> centre_mm;
  if (!o.centre_mm.empty()) centre_mm = Vec2(o.centre_mm[0], o.centre_mm[1]);
  auto check = calibrate::CheckCircle(points, o.radius_mm, centre_mm);
  if (!check) check.error().message = file + ": " + check.error().message;
  return check;
}

std::string CircleText(const calibrate::CircleCheck& c) {
  return fmt::format(
      "centre        {:.4f}, {:.4f} mm, radius {:.4f} mm, by smallest squares\n"
      "circular      {:.2f} um, deviation G\n"
      "radial        {:+.2f} um largest, {:+.2f} um smallest, deviation F\n"
      "scale         x {:+.2f} um/m beyond y\n"
      "squareness    {:+.2f} um/m\n"
      "rest          {:.2f} um without scale and squareness\n",
      c.centre_mm.x(), c.centre_mm.y(), c.radius_mm, 1e3 * c.circular_deviation_mm,
      1e3 * c.max_radial_mm, 1e3 * c.min_radial_mm, 1e6 * c.scale_ratio,
      1e6 * c.squareness_rad, 1e3 * c.rest_mm);
}

/// What differs between the directions.
std::string BothDirections(const DriveCircleOptions& o,
                           const calibrate::CircleCheck& left,
                           const calibrate::CircleCheck& right) {
  std::string text = fmt::format("both          squareness {:+.2f} um/m\n",
                                 1e6 * (left.squareness_rad + right.squareness_rad) / 2);
  if (!o.feed_mm_s) return text;
  const double lag_s =
      (left.squareness_rad - right.squareness_rad) / 2 * o.radius_mm / *o.feed_mm_s;
  return text + fmt::format("lags          x {:+.4f} ms behind y: {}\n", 1e3 * lag_s,
                            "give both axes the same position gain (intaglio drive tune "
                            "--regime circle)");
}

Result<bool> CheckCircles(const DriveCircleOptions& o) {
  const auto left = INTAGLIO_TRY(CheckOf(o, o.table));
  std::cout << CircleText(left);
  double worst_mm = left.circular_deviation_mm;
  if (!o.clockwise.empty()) {
    const auto right = INTAGLIO_TRY(CheckOf(o, o.clockwise));
    std::cout << "clockwise\n" << CircleText(right) << BothDirections(o, left, right);
    worst_mm = std::max(worst_mm, right.circular_deviation_mm);
  }
  if (!o.tolerance_um) return true;
  const bool good = 1e3 * worst_mm <= *o.tolerance_um;
  std::cout << fmt::format("verdict       {}: {:.2f} um of {:g} um\n",
                           good ? "GOOD" : "NOT GOOD", 1e3 * worst_mm, *o.tolerance_um);
  return good;
}

}  // namespace

void AddDriveCircleCommand(command_line::Command drive) {
  auto o = std::make_shared<DriveCircleOptions>();
  command_line::Command circle =
      drive.AddCommand("circle", "a measured circle, as ISO 230-4 evaluates it");
  circle.AddOption("table", o->table, "measured points, .csv: x_mm, y_mm").Require();
  circle.AddOption("--radius", o->radius_mm, "that was commanded, mm")
      .Positive()
      .Require();
  circle
      .AddOption("--centre", o->centre_mm,
                 "that was commanded, mm, in the frame of the table; default: of "
                 "smallest squares")
      .TakeValues(2);
  circle.AddOption("--clockwise", o->clockwise,
                   "a second table, run clockwise; the first is then counterclockwise");
  circle.AddOption("--feed", o->feed_mm_s, "of both, mm/s: then the lags of the axes")
      .Positive();
  circle.AddOption("--tolerance", o->tolerance_um, "of the circular deviation, um")
      .Positive();
  circle.SetFooter(
      "Example: intaglio drive circle left.csv --clockwise right.csv --radius 30 --feed "
      "33.3 --tolerance 20\n"
      "Exit code: 0 good, 2 wrong input, 3 beyond the tolerance.");
  circle.SetAction([o]() -> int {
    const auto good = CheckCircles(*o);
    if (!good) return Complain(good.error(), client::kExitWrongInput);
    return *good ? client::kExitGood : client::kExitNotGood;
  });
}

}  // namespace intaglio::cli
