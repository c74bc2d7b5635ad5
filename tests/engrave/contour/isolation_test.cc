#include "engrave/contour/isolation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "engrave/contour/gaps.h"
#include "tests/engrave/contour/boards.h"
#include "tests/engrave/contour/tables.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

/// Two boards' worth of named pads: A at the left, B at a gap to its right, C far away.
std::vector<Element> ThreePads(double gap) {
  return {{Circle{{0, 0}, 1}, "A"},
          {Square{{1 + gap, 0}, 1}, "B"},
          {Octagon{{10, 10}, 1}, "C"},
          {Track{{1 + gap, 0}, {1 + gap, 5}, 0.3}, "B-track"}};
}

double DistanceToPass(const IsolationPass& pass, const Vec2& p) {
  double nearest = 1e300;
  for (const Contour& contour : pass.contours) {
    for (const Edge& edge : contour.edges)
      nearest = std::min(nearest, DistanceTo(edge, p));
  }
  return nearest;
}

/// To the outline of squares and tracks; negative inside. Knows nothing of areas.
double DistanceToCopper(const std::vector<Element>& elements, const Vec2& p) {
  double nearest = 1e300;
  for (const Element& e : elements) {
    if (const auto* s = std::get_if<Square>(&e.shape)) {
      const Vec2 q = (p - s->center_mm).cwiseAbs() - Vec2::Constant(s->side_mm / 2);
      const double outside = q.cwiseMax(0.0).norm();
      nearest = std::min(nearest, outside > 0 ? outside : q.maxCoeff());
    } else if (const auto* t = std::get_if<Track>(&e.shape)) {
      const Vec2 along = t->end_mm - t->begin_mm;
      const double part =
          std::clamp((p - t->begin_mm).dot(along) / along.squaredNorm(), 0.0, 1.0);
      nearest =
          std::min(nearest, (p - t->begin_mm - part * along).norm() - t->width_mm / 2);
    }
  }
  return nearest;
}

std::vector<Element> SquaresAndTracks() {
  return {{Square{{0, 0}, 2}, ""},
          {Square{{2.55, 0.4}, 2}, ""},
          {Track{{0, 0}, {0, 4}, 0.5}, ""},
          {Track{{0, 4}, {1.3, 3.1}, 0.5}, ""},
          {Square{{3.1, 3.2}, 1}, ""},
          {Track{{2.55, 0.4}, {5, -2}, 0.3}, ""},
          {Track{{-2, -2}, {4, -2.6}, 0.2}, ""}};
}

TEST(Isolation, NamesNetsThatAreNearerThanTheToolIsWide) {
  const auto isolation = Isolate(ThreePads(0.18), {0.2});
  ASSERT_FALSE(isolation);
  EXPECT_EQ(isolation.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(isolation.error().message,
              HasSubstr("cannot isolate A from B: gap 0.18 < tool 0.2 at (0.59, 0)"));
  EXPECT_EQ(isolation.error().value, "0.18");
  EXPECT_TRUE(Isolate(ThreePads(0.18), {0.18}));
  EXPECT_TRUE(Isolate(ThreePads(0.2), {0.2}));
}

TEST(Isolation, CountsNetsAndCutsEachFromTheOthers) {
  const auto isolation = Isolate(ThreePads(0.3), {0.2});
  ASSERT_TRUE(isolation) << isolation.error().message;
  EXPECT_EQ(isolation->net_count, 3U);
  ASSERT_EQ(isolation->passes.size(), 1U);
  EXPECT_EQ(isolation->passes[0].contours.size(), 3U);
  EXPECT_NEAR(isolation->passes[0].offset_mm, 0.1, 1e-12);
  EXPECT_NEAR(isolation->width_mm, 0.2, 1e-12);
}

// Points of a fine raster: copper is never cut; behind the first pass everything up to
// the width is cut, in gaps and corners too.
TEST(Isolation, LeavesNoSliversAndCutsNoCopper) {
  const auto board = SquaresAndTracks();
  const auto isolation = Isolate(board, {0.3, 4, 0.5});
  ASSERT_TRUE(isolation) << isolation.error().message;
  EXPECT_NEAR(isolation->width_mm, 0.75, 1e-12);
  int cut = 0;
  for (double x = -4; x < 7; x += 0.047) {
    for (double y = -5; y < 6; y += 0.047) {
      const Vec2 p(x, y);
      double nearest = 1e300;
      for (const IsolationPass& pass : isolation->passes)
        nearest = std::min(nearest, DistanceToPass(pass, p));
      const double distance = DistanceToCopper(board, p);
      if (distance <= 0) {
        EXPECT_GE(nearest, 0.15 - 1e-5) << p.transpose();
      } else if (distance >= 0.15 && distance <= 0.75) {
        // Inside of 0.15 inner corners keep the tool's radius.
        EXPECT_LE(nearest, 0.15 + 1e-5) << p.transpose();
        ++cut;
      } else if (distance > 0.75) {
        EXPECT_GE(nearest, 0.15 - 1e-5) << p.transpose();
      }
    }
  }
  EXPECT_GT(cut, 5000);
}

TEST(Isolation, RefusesOptionsOutsideTheirRange) {
  const auto wrong = [](const IsolationOptions& options) {
    const auto isolation = Isolate(ThreePads(1), options);
    return isolation ? "" : isolation.error().message;
  };
  EXPECT_THAT(wrong({0}), HasSubstr("diameter"));
  EXPECT_THAT(wrong({0.2, 0}), HasSubstr("passes"));
  EXPECT_THAT(wrong({0.2, 2, 0.3}), HasSubstr("overlap"));
}

// Against the nearest of densely spaced points, whose error is below their distance.
TEST(Gaps, BetweenEdgesAreThoseOfDensePoints) {
  std::mt19937 random(3);
  const auto number = [&] { return 4 * test::Random(random) - 2; };
  const auto edge = [&](double x) {
    const Vec2 at(x + number(), number());
    return test::Random(random) < 0.5
               ? MakeLine(at, at + Vec2(number(), number()))
               : MakeArc(at, 0.1 + std::abs(number()), 3 * number(), 3 * number());
  };
  for (int k = 0; k < 200; ++k) {
    const Edge a = edge(0);
    const Edge b = edge(9);
    double nearest = 1e300;
    for (int i = 0; i <= 2000; ++i)
      nearest = std::min(nearest, DistanceTo(b, PointAt(a, a.length_mm * i / 2000)));
    const EdgeGap gap = GapBetween(a, b);
    EXPECT_LE(gap.distance_mm, nearest + 1e-12);
    EXPECT_NEAR(gap.distance_mm, nearest, a.length_mm / 2000);
    EXPECT_NEAR((gap.on_first_mm - gap.on_second_mm).norm(), gap.distance_mm, 1e-12);
  }
}

}  // namespace
}  // namespace intaglio::contour
