#include "engrave/discretize/spacing/contour_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace intaglio::discretize {
namespace {

PointList Points(const PointList& contour, bool closed, const ContourSpacing& spacing) {
  PointList points;
  AddContourPoints(contour, closed, spacing, points);
  return points;
}

const PointList kLine = {Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(3, 0, 0), Vec3(10, 0, 0)};
const PointList kSquare = {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(4, 4, 0), Vec3(0, 4, 0)};

TEST(ContourPoints, OfALineKeepItsEnds) {
  const PointList points = Points(kLine, false, {0.6, 0.3, true});
  // 10 / (0.6 x 1.004) = 16.6 parts.
  ASSERT_EQ(points.size(), 17u);
  for (std::size_t i = 0; i < 17; ++i) {
    EXPECT_NEAR(points[i].x(), 10.0 * static_cast<double>(i) / 16, 1e-12);
  }
  EXPECT_EQ(points.front(), kLine.front());
  EXPECT_EQ(points.back(), kLine.back());
}

TEST(ContourPoints, OfALineWithoutItsEndsShiftByThePhase) {
  for (const double phase : {0.0, 0.3, 0.5, 0.9}) {
    const PointList points = Points(kLine, false, {0.6, phase, false});
    ASSERT_EQ(points.size(), 16u);
    const double first = std::fmod(0.5 + phase, 1.0);
    for (std::size_t i = 0; i < 16; ++i) {
      EXPECT_NEAR(points[i].x(), (static_cast<double>(i) + first) * 10 / 16, 1e-12);
    }
  }
}

TEST(ContourPoints, OfAClosedContourGoRoundItWithoutASeam) {
  const PointList points = Points(kSquare, true, {0.5, 0.25, true});
  ASSERT_EQ(points.size(), 31u);  // 16 / (0.5 x 1.004) = 31.9
  const auto arc = [](const Vec3& p) {
    if (p.y() == 0) return p.x();
    if (p.x() == 4) return 4 + p.y();
    return p.y() == 4 ? 12 - p.x() : 16 - p.y();
  };
  for (std::size_t i = 0; i < 31; ++i) {
    EXPECT_NEAR(arc(points[i]), (static_cast<double>(i) + 0.25) * 16 / 31, 1e-12);
  }
}

TEST(ContourPoints, OfAShortContourAreOne) {
  EXPECT_EQ(Points(kSquare, true, {100, 0, true}).size(), 1u);
  EXPECT_EQ(Points(kLine, false, {100, 0, true}), PointList{Vec3(5, 0, 0)});
  EXPECT_EQ(Points({Vec3(1, 2, 3)}, false, {1, 0, true}), PointList{Vec3(1, 2, 3)});
  EXPECT_EQ(Points({Vec3(1, 2, 3)}, true, {1, 0, true}), PointList{Vec3(1, 2, 3)});
  EXPECT_TRUE(Points({}, true, {1, 0, true}).empty());
}

TEST(ContourPoints, OfSharesAreThoseOfTheWhole) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> step(-0.3, 0.3);
  for (int round = 0; round < 100; ++round) {
    PointList corners = {Vec3(0, 0, 0)};
    std::vector<double> arc = {0};
    for (int i = 0; i < 100; ++i) {
      corners.push_back(corners.back() + Vec3(step(random), step(random), step(random)));
      arc.push_back(arc.back() + (corners.back() - corners[corners.size() - 2]).norm());
    }
    const MeasuredContour contour = {corners, arc};
    const bool closed = round % 2 == 0;
    const ContourSteps steps =
        StepsAlong(arc.back(), closed, {0.07, 0.01 * round, round % 4 == 1});
    PointList whole, shares;
    AddSteps(contour, steps, 0, 100, whole);
    EXPECT_EQ(whole.size(), steps.point_count());
    for (std::size_t begin = 0; begin < 100;) {
      const std::size_t end = std::min<std::size_t>(100, begin + 1 + random() % 20);
      AddSteps(contour, steps, begin, end, shares);
      begin = end;
    }
    EXPECT_EQ(shares, whole);
  }
}

}  // namespace
}  // namespace intaglio::discretize
