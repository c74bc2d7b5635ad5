// A grbl refuses any one line of a run of points ("error:N"), and goes on with those that
// follow in its buffer: no way is lit but the beginning of the way from a point.

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "tests/services/drivers/grbl/grbl_cell.h"

namespace intaglio::drivers {
namespace {

constexpr int kPoints = 24;
constexpr double kPitch_mm = 0.3;
// A busy computer stalls so long; enough for all that the driver sends ahead.
constexpr int kStall_ms = 200;

Vec3 PlaceOf(const grbl::Steps& at, double steps_per_mm) {
  return Vec3(double(at[0]), double(at[1]), double(at[2])) / steps_per_mm;
}

double DistanceToWay(const Vec3& from, const Vec3& to, const Vec3& place) {
  const Vec3 way = to - from;
  const double part =
      std::clamp((place - from).dot(way) / std::max(1e-12, way.squaredNorm()), 0.0, 1.0);
  return (from + part * way - place).norm();
}

/// The farthest place of the flash from the plan, mm: it begins at a point, and is lit on
/// no more than the first half of the way from there, or as far as a step aside.
double OffThePlan(const grbl::Flash& flash, const std::vector<Vec3>& points,
                  double steps_per_mm) {
  const Vec3 on = PlaceOf(flash.on_at, steps_per_mm);
  const Vec3 off = PlaceOf(flash.off_at, steps_per_mm);
  const double aside_mm = 4 / steps_per_mm;
  double off_plan_mm = 1e9;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 half =
        i + 1 < points.size() ? Vec3((points[i] + points[i + 1]) / 2) : points[i];
    const double end_mm = std::min(DistanceToWay(points[i], half, off),
                                   std::max(0.0, (points[i] - off).norm() - aside_mm));
    off_plan_mm = std::min(off_plan_mm, std::max((points[i] - on).norm(), end_mm));
  }
  return off_plan_mm;
}

class GrblRefusedLine : public ::testing::TestWithParam<bool> {
 protected:
  /// Once: nothing turns the host, so nothing stops what the controller has.
  void Stall(GrblCell& cell) {
    for (int i = std::exchange(stall_ms_, 0); i > 0; --i) cell.machine.Advance();
  }
  /// False: the run had no such line.
  bool RefuseOne(const grbl::VirtualGrblOptions& options, std::uint64_t line) {
    GrblCell cell(options);
    stall_ms_ = kStall_ms;
    cell.Prepare();
    cell.Begin(kPoints, kPitch_mm, GetParam());
    cell.machine.grbl.RefuseLineBehind(line);
    const bool over = cell.Until([&] {
      if (stall_ms_ > 0 && !cell.machine.grbl.refuses()) Stall(cell);
      return cell.RunIsOver() || cell.driver->state().fault != intaglio_MOTION_OK;
    });
    EXPECT_TRUE(over) << line;
    if (cell.machine.grbl.refuses()) return false;
    cell.feeds = false;
    cell.Until([] { return false; }, 1500);
    std::vector<Vec3> points;
    for (const auto& [tick, place] : cell.points) points.push_back(place);
    const double steps_per_mm = options.motion.steps_per_mm;
    // A step of each axis, and the controller's rounding.
    const double near_mm = 2 / steps_per_mm;
    for (const grbl::Flash& flash : cell.machine.grbl.motion().flashes())
      worst_mm_ = std::max(worst_mm_, OffThePlan(flash, points, steps_per_mm));
    EXPECT_LE(worst_mm_, near_mm) << "line " << line << " was refused";
    EXPECT_EQ(cell.machine.grbl.motion().lit_at_rest_us(), 0) << line;
    EXPECT_NE(cell.driver->state().fault, intaglio_MOTION_OK) << line;
    return true;
  }
  double worst_mm_ = 0;
  int stall_ms_ = 0;
};

TEST_P(GrblRefusedLine, LightsNothingBesideThePlan) {
  for (const auto& options : {grbl::Grbl11(), grbl::GrblHal()}) {
    std::uint64_t line = 0;
    while (!HasFailure() && RefuseOne(options, line)) ++line;
    EXPECT_GT(line, 2U * kPoints) << "a lit and a dark one of each point";
  }
}

INSTANTIATE_TEST_SUITE_P(, GrblRefusedLine, ::testing::Bool(), [](const auto& row) {
  return row.param ? "AtRest" : "OnTheWay";
});

}  // namespace
}  // namespace intaglio::drivers
