#include "engrave/contour/region/simplify.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace intaglio::contour {
namespace {

using std::numbers::pi;

/// A closed outline around a circle of 10 mm, up and down by waves and by chance.
Region Wavy(int count, double wave_mm, double noise_mm, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Vec2> points;
  for (int k = 0; k < count; ++k) {
    const double a = 2 * pi * k / count;
    const double by_chance = static_cast<double>(random() % 2001) / 1000 - 1;
    const double r = 10 + wave_mm * std::sin(9 * a) + noise_mm * by_chance;
    points.push_back(r * Vec2(std::cos(a), std::sin(a)));
  }
  Region region{{{}}};
  for (int k = 0; k < count; ++k)
    region.loops[0].push_back(
        MakeLine(points[static_cast<std::size_t>(k)],
                 points[static_cast<std::size_t>((k + 1) % count)]));
  return region;
}

double DistanceToLoops(const Region& region, const Vec2& p) {
  double nearest = 1e300;
  for (const Edges& loop : region.loops) {
    for (const Edge& edge : loop) nearest = std::min(nearest, DistanceTo(edge, p));
  }
  return nearest;
}

/// The largest distance of one border from the other, at many of its places.
double Farthest(const Region& from, const Region& to) {
  double farthest = 0;
  for (const Edges& loop : from.loops) {
    for (const Edge& edge : loop) {
      for (const double part : {0.0, 0.25, 0.5, 0.75})
        farthest =
            std::max(farthest, DistanceToLoops(to, PointAt(edge, part * edge.length_mm)));
    }
  }
  return farthest;
}

TEST(Simplified, KeepsItsToleranceOnBothSides) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Region fine = Wavy(2000, 1, seed % 2 == 0 ? 0.002 : 0, seed);
    const Region simple = Simplified(fine, 0.004);
    EXPECT_LT(simple.loops[0].size(), 800U) << seed;
    EXPECT_LE(Farthest(simple, fine), 0.004) << seed;
    EXPECT_LE(Farthest(fine, simple), 0.004) << seed;
    EXPECT_EQ(simple.loops[0][0].begin_mm, fine.loops[0][0].begin_mm);
    EXPECT_EQ(simple.loops[0].back().end_mm, fine.loops[0][0].begin_mm);
  }
}

// By hand: a chord of a circle of r = 5 within half of 0.01 mm spans 2 acos(1 - 0.001),
// so 71 chords; lines that are none of a run stay.
TEST(Simplified, MakesArcsChordsAndLeavesLongLines) {
  const Region disc{{{MakeArc({0, 0}, 5, 0, 2 * pi)}}};
  const Region simple = Simplified(disc, 0.01);
  EXPECT_LE(Farthest(simple, disc), 0.01);
  EXPECT_GE(simple.loops[0].size(), 40U);
  EXPECT_LE(simple.loops[0].size(), 71U);
  const Region square{{{MakeLine({0, 0}, {9, 0}), MakeLine({9, 0}, {9, 9}),
                        MakeLine({9, 9}, {0, 9}), MakeLine({0, 9}, {0, 0})}}};
  EXPECT_EQ(Simplified(square, 0.01).loops[0].size(), 4U);
}

// The oracle: the distance of every edge of the outline. An inset of 1.5 mm is far wider
// than the edges of 0.02 mm are long, so it takes several stages.
TEST(InsetInStages, KeepsItsDistanceFromEveryEdge) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Region fine = Wavy(3000, 0.8, 0.001, seed);
    const auto inset = InsetInStages(fine, 1.5, 0.002);
    ASSERT_TRUE(inset) << inset.error().message;
    ASSERT_EQ(inset->loops.size(), 1U);
    for (const Edge& edge : inset->loops[0]) {
      for (const double part : {0.0, 0.5}) {
        const Vec2 place = PointAt(edge, part * edge.length_mm);
        EXPECT_TRUE(IsInside(fine, place));
        EXPECT_NEAR(DistanceToLoops(fine, place), 1.5, 0.002);
      }
    }
  }
}

TEST(InsetInStages, OfWhatIsTooNarrowIsNothing) {
  const auto inset = InsetInStages(Wavy(1000, 0.5, 0, 1), 11, 0.002);
  ASSERT_TRUE(inset) << inset.error().message;
  EXPECT_TRUE(inset->loops.empty());
}

}  // namespace
}  // namespace intaglio::contour
