#include "engrave/contour/region/region.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "tests/engrave/contour/boards.h"
#include "tests/engrave/contour/covered_area.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;

Region Drawn(const std::vector<Element>& elements) {
  const auto drawn = Unite(elements);
  EXPECT_TRUE(drawn) << drawn.error().message;
  return drawn ? RegionOf(*drawn) : Region{};
}

Edges Box(const Vec2& a, const Vec2& b) {
  return {MakeLine(a, {b.x(), a.y()}), MakeLine({b.x(), a.y()}, b),
          MakeLine(b, {a.x(), b.y()}), MakeLine({a.x(), b.y()}, a)};
}

double DistanceToBorder(const Region& region, const Vec2& p) {
  double nearest = 1e300;
  for (const Edges& loop : region.loops) {
    for (const Edge& edge : loop) nearest = std::min(nearest, DistanceTo(edge, p));
  }
  return nearest;
}

std::vector<Element> Joint(std::vector<Element> a, const std::vector<Element>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// The oracle integrates scan lines over the elements: |A without B| = |A or B| - |B|.
// Coordinates are rounded to 1 nm, on contours of some 100 mm.
TEST(Region, DifferenceAndIntersectionHaveTheAreaOfScanLines) {
  int refused = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const bool free_angles = seed % 2 == 0;
    const auto a = test::MakeBoard({20, seed, free_angles});
    const auto b = test::MakeBoard({12, seed + 100, free_angles});
    const Region drawn = Drawn(a);
    const Region cleared = Drawn(b);
    const auto rest = Difference(drawn, cleared);
    const auto common = Intersection(drawn, cleared);
    if (!rest || !common) {
      ++refused;
      continue;
    }
    const double area_a = test::CoveredArea_mm2(a, 0);
    const double area_b = test::CoveredArea_mm2(b, 0);
    const double area_both = test::CoveredArea_mm2(Joint(a, b), 0);
    EXPECT_NEAR(AreaOf(*rest), area_both - area_b, 1e-5) << seed;
    EXPECT_NEAR(AreaOf(*common), area_a + area_b - area_both, 1e-5) << seed;
  }
  EXPECT_EQ(refused, 0);
}

TEST(Region, NoPointIsOnTheWrongSide) {
  const Region drawn = Drawn(test::MakeBoard({25, 7, true}));
  const Region cleared = Drawn(test::MakeBoard({15, 8, true}));
  const auto rest = Difference(drawn, cleared);
  ASSERT_TRUE(rest) << rest.error().message;
  std::mt19937 random(1);
  for (int k = 0; k < 3000; ++k) {
    const Vec2 p(14 * test::Random(random) - 2, 14 * test::Random(random) - 2);
    if (DistanceToBorder(drawn, p) < 1e-5 || DistanceToBorder(cleared, p) < 1e-5)
      continue;
    EXPECT_EQ(IsInside(*rest, p), IsInside(drawn, p) && !IsInside(cleared, p));
  }
}

TEST(Region, BordersThatRunAlongEachOtherAreDecidedOnce) {
  const Region square{{Box({0, 0}, {4, 4})}};
  const auto area = [&](const Edges& other) {
    const auto rest = Difference(square, {{other}});
    EXPECT_TRUE(rest) << rest.error().message;
    return rest ? AreaOf(*rest) : -1;
  };
  EXPECT_NEAR(area(Box({0, 0}, {4, 4})), 0, 1e-12);
  EXPECT_NEAR(area(Box({0, 0}, {2, 4})), 8, 1e-12);
  EXPECT_NEAR(area(Box({4, 0}, {8, 4})), 16, 1e-12);
  EXPECT_NEAR(area(Box({1, 1}, {2, 2})), 15, 1e-12);
  EXPECT_NEAR(area(Box({-1, -1}, {9, 9})), 0, 1e-12);
  EXPECT_NEAR(area(Box({9, 9}, {10, 10})), 16, 1e-12);
  EXPECT_NEAR(area({MakeArc({0, 2}, 2, 0, 2 * pi)}), 16 - 2 * pi, 1e-9);
  const auto common = Intersection(square, square);
  ASSERT_TRUE(common);
  EXPECT_NEAR(AreaOf(*common), 16, 1e-12);
}

// By the distance to the border, which knows nothing of offsets.
TEST(Region, InsetAndOutsetKeepTheirDistance) {
  const Region region = Drawn(test::MakeBoard({25, 3, true}));
  constexpr double kDistance_mm = 0.17;
  const auto inset = Inset(region, kDistance_mm);
  const auto outset = Outset(region, kDistance_mm);
  ASSERT_TRUE(inset) << inset.error().message;
  ASSERT_TRUE(outset) << outset.error().message;
  std::mt19937 random(1);
  int inside = 0;
  for (int k = 0; k < 5000; ++k) {
    const Vec2 p(14 * test::Random(random) - 2, 14 * test::Random(random) - 2);
    const double from_border = DistanceToBorder(region, p);
    if (std::abs(from_border - kDistance_mm) < 1e-5) continue;
    const bool is_inside = IsInside(region, p);
    EXPECT_EQ(IsInside(*inset, p), is_inside && from_border > kDistance_mm);
    EXPECT_EQ(IsInside(*outset, p), is_inside || from_border < kDistance_mm);
    inside += IsInside(*inset, p) ? 1 : 0;
  }
  EXPECT_GT(inside, 100);
}

// A half disc on a box: points on their common line, the chord, are inside.
TEST(Region, PointsOnAChordAreInside) {
  for (const bool lower : {false, true}) {
    for (const bool clockwise : {false, true}) {
      Edge arc = MakeArc({5, 3}, 2, lower ? pi : 0, pi);
      if (clockwise) arc = Reversed(arc);
      // The other way would leave the chord's ends 1e-16 off its height.
      arc.begin_mm.y() = arc.end_mm.y() = 3;
      const double y = lower ? 4 : 2;
      const Vec2 far_end(arc.end_mm.x(), y);
      const Vec2 far_begin(arc.begin_mm.x(), y);
      const Region region{
          {{arc, MakeLine(arc.end_mm, far_end), MakeLine(far_end, far_begin),
            MakeLine(far_begin, arc.begin_mm)}}};
      for (double x = 3.1; x < 7; x += 0.1)
        EXPECT_TRUE(IsInside(region, {x, 3})) << x << " " << lower << clockwise;
    }
  }
}

// Elements on one raster: borders coincide, and end on each other's chords.
TEST(Region, BoardsOnOneRasterAreTakenApart) {
  int refused = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const Region a = Drawn(test::MakeBoard({60, seed, seed % 2 == 0}));
    const Region b = Drawn(test::MakeBoard({40, seed + 1000, seed % 2 == 0}));
    const auto rest = Difference(a, b);
    const auto common = Intersection(b, a);
    if (!rest || !common) {
      ++refused;
      continue;
    }
    EXPECT_NEAR(AreaOf(*rest) + AreaOf(*common), AreaOf(a), 1e-5) << seed;
  }
  EXPECT_EQ(refused, 0);
}

TEST(Region, ConnectedPartsHaveTheirHoles) {
  const auto region =
      RegionOfLoops({Box({0, 0}, {10, 10}), Box({1, 1}, {9, 9}), Box({2, 2}, {4, 4}),
                     Box({5, 5}, {8, 8}), Box({6, 6}, {7, 7}), Box({20, 0}, {21, 1})});
  ASSERT_TRUE(region) << region.error().message;
  const auto parts = ConnectedParts(*region);
  ASSERT_EQ(parts.size(), 4U);
  EXPECT_NEAR(AreaOf(parts[0]), 100 - 64, 1e-9);
  EXPECT_NEAR(AreaOf(parts[1]), 4, 1e-9);
  EXPECT_NEAR(AreaOf(parts[2]), 9 - 1, 1e-9);
  EXPECT_NEAR(AreaOf(parts[3]), 1, 1e-9);
}

TEST(Region, ClearedElementsKeepTheirNames) {
  const std::vector<Element> drawn{{Circle{{0, 0}, 2}, "R1-1"},
                                   {Track{{0, 0}, {10, 0}, 1}, "GND"},
                                   {Square{{10, 0}, 2}, "R1-2"}};
  const auto rest = Cleared(drawn, std::vector<Element>{{Square{{5, 0}, 3}, ""}});
  ASSERT_TRUE(rest) << rest.error().message;
  ASSERT_EQ(rest->size(), 4U);
  EXPECT_EQ((*rest)[0].name, "R1-1");
  EXPECT_TRUE(std::holds_alternative<Circle>((*rest)[0].shape));
  EXPECT_EQ((*rest)[1].name, "GND");
  EXPECT_EQ((*rest)[2].name, "GND");
  const auto united = Unite(*rest);
  ASSERT_TRUE(united) << united.error().message;
  EXPECT_EQ(united->group_count, 2U);
  const auto nothing = Cleared(drawn, std::vector<Element>{{Square{{5, 0}, 30}, ""}});
  ASSERT_TRUE(nothing);
  EXPECT_TRUE(nothing->empty());
}

}  // namespace
}  // namespace intaglio::contour
