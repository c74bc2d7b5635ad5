// Trochimczuk 2008, annex D, table 10: more than 2 000 000 points in one picture.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "engrave/motion/tick_planner.h"
#include "engrave/sort/order.h"

namespace intaglio::sort {
namespace {

/// A spiral over a ball of 100 mm, the points 0.12 mm apart.
PointList Ball(std::size_t count) {
  const double radius_mm = 50, turns = std::sqrt(std::numbers::pi * count) / 2;
  PointList points;
  points.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double height = -1 + 2 * (i + 0.5) / count;
    const double from_axis = std::sqrt(1 - height * height);
    const double angle = 2 * turns * std::acos(-height);
    points.push_back(radius_mm * Vec3(1 + from_axis * std::cos(angle),
                                      1 + from_axis * std::sin(angle), 1 + height));
  }
  return points;
}

TEST(TwoMillionPoints, AreOrderedAndPlanned) {
  const PointList points = Ball(2'000'001);
  OrderOptions options;
  options.method = Method::kKdz;
  options.cone = BeamCone(0.038);
  const auto order = MakeOrder(points, options, {});
  ASSERT_TRUE(order.has_value()) << order.error().message;
  ASSERT_EQ(order->size(), points.size());
  std::vector<bool> seen(points.size());
  const motion::Limits limits{Vec3::Constant(80), Vec3::Constant(7000)};
  motion::TickPlanner planner(limits, 100, {}, {});
  std::vector<motion::Segment> segments;
  std::size_t passed = 0;
  const auto count = [&] {
    for (const motion::Segment& segment : segments) passed += segment.point >= 0 ? 1 : 0;
    segments.clear();
  };
  for (std::size_t i = 0; i < order->size(); ++i) {
    const std::uint32_t index = (*order)[i];
    ASSERT_FALSE(seen[index]) << "a point occurs twice in the order";
    seen[index] = true;
    planner.Append(points[index], static_cast<std::int32_t>(i), true, segments);
    if (segments.size() > 4096) count();
  }
  planner.Finish(segments);
  count();
  EXPECT_EQ(passed, points.size());
  // At best a point a tick.
  EXPECT_GE(planner.ticks(), points.size());
  EXPECT_LT(planner.ticks(), 2 * points.size());
}

}  // namespace
}  // namespace intaglio::sort
