#include "engrave/core/convex_hull.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace intaglio {
namespace {

double Turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b.x() - a.x()) * (c.y() - b.y()) - (b.y() - a.y()) * (c.x() - b.x());
}

// By its definition: every corner turns left, and no point is on the right of an edge.
TEST(ConvexHull, HasAllPointsOnTheLeftOfItsEdges) {
  std::mt19937 random(5);
  for (const int count : {3, 10, 1000}) {
    std::vector<Vec2> points;
    std::normal_distribution<double> normal(0, 20);
    for (int i = 0; i < count; ++i) points.emplace_back(normal(random), normal(random));
    points.push_back(points.front());
    const std::vector<Vec2> hull = ConvexHull(points);
    ASSERT_GE(hull.size(), 3u);
    for (std::size_t i = 0; i < hull.size(); ++i) {
      const Vec2 from = hull[i], to = hull[(i + 1) % hull.size()];
      EXPECT_GT(Turn(from, to, hull[(i + 2) % hull.size()]), 0);
      for (const Vec2& point : points) EXPECT_GE(Turn(from, to, point), -1e-9);
      EXPECT_NE(std::find(points.begin(), points.end(), from), points.end());
    }
  }
}

TEST(ConvexHull, OfPointsInALineIsItsEnds) {
  EXPECT_TRUE(ConvexHull({}).empty());
  EXPECT_EQ(ConvexHull({Vec2(2, 3), Vec2(2, 3)}), (std::vector<Vec2>{Vec2(2, 3)}));
  EXPECT_EQ(ConvexHull({Vec2(2, 3), Vec2(0, 1), Vec2(1, 2)}),
            (std::vector<Vec2>{Vec2(0, 1), Vec2(2, 3)}));
  // Points on the edges are no corners.
  EXPECT_EQ(ConvexHull({Vec2(0, 0), Vec2(1, 0), Vec2(2, 0), Vec2(2, 1), Vec2(2, 2),
                        Vec2(1, 2), Vec2(0, 2), Vec2(1, 1)}),
            (std::vector<Vec2>{Vec2(0, 0), Vec2(2, 0), Vec2(2, 2), Vec2(0, 2)}));
}

// A circle's polygon of n corners lies R (1 - cos(pi / n)) within it. The corners that
// stay are not all at equal distances: the longest edge may be twice as long, with four
// times the height.
TEST(WithFewerCorners, StaysNearTheCircleThatItHadCornersOf) {
  constexpr double kRadius = 25;
  std::vector<Vec2> circle;
  for (int i = 0; i < 1000; ++i) {
    const double angle = 2 * std::numbers::pi * i / 1000;
    circle.emplace_back(kRadius * std::cos(angle), kRadius * std::sin(angle));
  }
  const std::vector<Vec2> fewer = WithFewerCorners(circle, 64);
  ASSERT_EQ(fewer.size(), 64u);
  const double within = 4 * kRadius * (1 - std::cos(std::numbers::pi / 64));
  for (std::size_t i = 0; i < fewer.size(); ++i) {
    EXPECT_NE(std::find(circle.begin(), circle.end(), fewer[i]), circle.end());
    const Vec2 middle = (fewer[i] + fewer[(i + 1) % fewer.size()]) / 2;
    EXPECT_GT(middle.norm(), kRadius - within);
  }
  EXPECT_EQ(WithFewerCorners({Vec2(0, 0), Vec2(1, 0), Vec2(0, 1)}, 3).size(), 3u);
  EXPECT_EQ(WithFewerCorners({Vec2(0, 0), Vec2(1, 0), Vec2(0, 1)}, 1).size(), 1u);
}

}  // namespace
}  // namespace intaglio
