#include "engrave/contour/milling/pocket.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "engrave/contour/region/region.h"
#include "engrave/core/try.h"
#include "tests/engrave/contour/boards.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

Edges Rectangle(const Vec2& a, const Vec2& b) {
  return {MakeLine(a, {b.x(), a.y()}), MakeLine({b.x(), a.y()}, b),
          MakeLine(b, {a.x(), b.y()}), MakeLine({a.x(), b.y()}, a)};
}

Edges Disc(const Vec2& center, double radius) {
  return {MakeArc(center, radius, 0, 2 * pi)};
}

Region Area(const std::vector<Edges>& loops) {
  const auto region = RegionOfLoops(loops);
  EXPECT_TRUE(region) << region.error().message;
  return region ? *region : Region{};
}

double DistanceToLoops(const std::vector<Edges>& loops, const Vec2& p) {
  double nearest = 1e300;
  for (const Edges& loop : loops) {
    for (const Edge& edge : loop) nearest = std::min(nearest, DistanceTo(edge, p));
  }
  return nearest;
}

/// What a tool leaves inside an area, with any path: the area without the discs of the
/// tool that fit into it. It knows nothing of passes.
Result<Region> Unreached(const Region& area, double tool_diameter_mm) {
  const double radius_mm = tool_diameter_mm / 2;
  const Region shrunk = INTAGLIO_TRY(Inset(area, radius_mm));
  if (shrunk.loops.empty()) return area;
  return Difference(area, INTAGLIO_TRY(Outset(shrunk, radius_mm)));
}

/// A pocket with a slanted wall, an island, a neck and a bay with a round end.
Region Irregular() {
  return Area(
      {{MakeLine({0, 0}, {30, 3}), MakeLine({30, 3}, {28, 20}),
        MakeArcBetween({28, 20}, {20, 20}, {24, 20}, true), MakeLine({20, 20}, {16, 12}),
        MakeLine({16, 12}, {13, 12}), MakeLine({13, 12}, {10, 24}),
        MakeLine({10, 24}, {-3, 18}), MakeLine({-3, 18}, {0, 0})},
       Disc({21, 9}, 2.5),
       Rectangle({3, 8}, {6, 13})});
}

double NearestCut(const Pocket& pocket, const Vec2& p) {
  double nearest = 1e300;
  for (const PocketPass& pass : pocket.passes)
    nearest = std::min(nearest, DistanceToLoops(pass.paths, p));
  return nearest;
}

// The oracle knows distances alone: a point is cut when a path is within the radius; it
// can be reached when a point nearby is at least the radius from the wall. Of the border
// of both 0.02 mm are left out: a raster of the tool's places has that fineness.
void ExpectEverythingReachableCut(const Region& area, const Pocket& pocket,
                                  double tool_mm) {
  const double r = tool_mm / 2;
  std::mt19937 random(1);
  int cut_count = 0;
  for (int k = 0; k < 6000; ++k) {
    const Vec2 p(36 * test::Random(random) - 4, 28 * test::Random(random) - 2);
    const bool inside = IsInside(area, p);
    const double nearest = NearestCut(pocket, p);
    if (!inside) {
      EXPECT_GT(nearest, r - 1e-5) << "cut outside at " << p.transpose();
      continue;
    }
    const double from_wall = DistanceToLoops(area.loops, p);
    // A place for the tool's centre from which it reaches the point: uphill.
    bool reachable = from_wall > r + 1e-4;
    for (int a = 0; a < 90 && !reachable; ++a) {
      const Vec2 center =
          p + (r - 0.01) * Vec2(std::cos(a * pi / 45), std::sin(a * pi / 45));
      reachable =
          IsInside(area, center) && DistanceToLoops(area.loops, center) > r + 1e-4;
    }
    if (!reachable) continue;
    EXPECT_LT(nearest, r + 1e-5) << "left uncut at " << p.transpose();
    ++cut_count;
  }
  EXPECT_GT(cut_count, 1500);
}

TEST(Pocket, CutsWhatTheToolReachesAndNothingElse) {
  const Region area = Irregular();
  for (const double step : {0.2, 0.5, 0.7, 0.95}) {
    const auto pocket = ClearPocket(area, {2, step});
    ASSERT_TRUE(pocket) << pocket.error().message;
    ExpectEverythingReachableCut(area, *pocket, 2);
  }
}

/// Around a centre, waves and a fine noise as of a zone of a layout program.
Edges FineOutline(const Vec2& center, double radius, double wave_mm, int count) {
  std::mt19937 random(7);
  std::vector<Vec2> points;
  for (int k = 0; k < count; ++k) {
    const double a = 2 * pi * k / count;
    const double r = radius + wave_mm * std::sin(11 * a) + 1e-4 * test::Random(random);
    points.push_back(center + r * Vec2(std::cos(a), std::sin(a)));
  }
  Edges loop;
  for (std::size_t k = 0; k < points.size(); ++k)
    loop.push_back(MakeLine(points[k], points[(k + 1) % points.size()]));
  return loop;
}

// Edges of 10 um. With all of them in all passes, and all passes united with all, this
// took minutes and gigabytes; a pass needs as many edges as its tolerance of 2 um asks
// for.
TEST(Pocket, OfManyEdgesCutsAllWithFewEdges) {
  const Region area =
      Area({FineOutline({14, 12}, 10, 0.6, 6000), FineOutline({15, 12}, 3, 0.2, 2000)});
  for (const double step : {0.45, 0.8}) {
    const auto pocket = ClearPocket(area, {0.8, step});
    ASSERT_TRUE(pocket) << pocket.error().message;
    for (const PocketPass& pass : pocket->passes) {
      std::size_t count = 0;
      for (const Edges& path : pass.paths) count += path.size();
      EXPECT_LT(count, 2500U) << "at " << pass.offset_mm;
    }
    ExpectEverythingReachableCut(area, *pocket, 0.8);
    // Both outlines are wide enough for the tool all along: 4 um along 100 mm.
    EXPECT_LT(pocket->left_area_mm2, 0.4);
  }
}

// All distances anew, from the wall itself: roundings of 16 passes at most.
TEST(Pocket, PassesKeepTheirDistanceFromTheWall) {
  const Region area = Irregular();
  const auto pocket = ClearPocket(area, {1, 0.1});
  ASSERT_TRUE(pocket) << pocket.error().message;
  EXPECT_GT(pocket->passes.size(), 33U);  // twice past those made from the wall
  for (const PocketPass& pass : pocket->passes) {
    for (const Edges& path : pass.paths) {
      for (const Edge& edge : path) {
        for (const double part : {0.0, 0.3, 0.5, 0.8}) {
          const Vec2 p = PointAt(edge, part * edge.length_mm);
          EXPECT_NEAR(DistanceToLoops(area.loops, p), pass.offset_mm, 2e-5);
        }
      }
    }
  }
}

// Passes of two walls meet exactly in a frame of whole steps, whose proof fails then: all
// but its outer corners is cleared even so, with a smaller step.
TEST(Pocket, OfAFrameOfWholeStepsLeavesItsCornersAlone) {
  constexpr double kDiameter = 2;
  for (int count = 1; count <= 6; ++count) {
    const double width = kDiameter * (1 + count);
    const auto frame = Area({Rectangle({0, 0}, {20 + 2 * width, 20 + 2 * width}),
                             Rectangle({width, width}, {width + 20, width + 20})});
    const auto pocket = ClearPocket(frame, {kDiameter, 0.5});
    ASSERT_TRUE(pocket) << width << ": " << pocket.error().message;
    EXPECT_NEAR(pocket->left_area_mm2, 4 - pi, 1e-4) << width;
  }
}

// By hand: of a rectangle four corners of (1 - pi / 4) r^2 stay.
TEST(Pocket, LeavesTheCornersThatAreSharperThanTheTool) {
  for (const double step : {0.3, 0.5, 0.6, 0.8, 0.95}) {
    const auto pocket = ClearPocket(Area({Rectangle({0, 0}, {37, 23})}), {3, step});
    ASSERT_TRUE(pocket) << pocket.error().message;
    EXPECT_NEAR(pocket->left_area_mm2, (4 - pi) * 2.25, 1e-5) << step;
    EXPECT_NEAR(pocket->cut_area_mm2, 37 * 23 - (4 - pi) * 2.25, 1e-5) << step;
    EXPECT_NEAR(pocket->passes.back().offset_mm, 1.5, 1e-12);
  }
}

TEST(Pocket, PutsPassesInOnlyWhereWideStepsLeaveStrips) {
  const auto between = [](double step) {
    const auto pocket = ClearPocket(Area({Disc({0, 0}, 10)}), {2, step});
    EXPECT_TRUE(pocket) << pocket.error().message;
    if (!pocket) return -1;
    int count = 0;
    for (const PocketPass& pass : pocket->passes) count += pass.between ? 1 : 0;
    EXPECT_NEAR(pocket->left_area_mm2, 0, 1e-5);
    return count;
  };
  EXPECT_EQ(between(0.5), 0);
  // Passes at 1, 2.9, 4.8, 6.7, 8.6 from the wall: the last has a radius of 1.4 and
  // leaves a disc of 0.4 in its middle.
  EXPECT_EQ(between(0.95), 1);
  // 1, 2.8, 4.6, 6.4, 8.2, 10 - the middle itself.
  EXPECT_EQ(between(0.85), 0);
}

TEST(Pocket, KeepsTheAllowance) {
  const auto pocket =
      ClearPocket(Area({Disc({0, 0}, 10), Disc({1, 0}, 3)}), {2, 0.4, 0.5});
  ASSERT_TRUE(pocket) << pocket.error().message;
  // The ring between 9.5 and 3.5 is everywhere wider than the tool.
  EXPECT_NEAR(pocket->cut_area_mm2, pi * (9.5 * 9.5 - 3.5 * 3.5), 1e-5);
  EXPECT_NEAR(pocket->left_area_mm2, 0, 1e-5);
}

TEST(Pocket, NamesThePartThatIsTooNarrow) {
  const auto pocket = ClearPocket(
      Area({Rectangle({0, 0}, {20, 20}), Rectangle({40, 0}, {60, 1.5})}), {2, 0.4});
  ASSERT_FALSE(pocket);
  EXPECT_THAT(
      pocket.error().message,
      HasSubstr("the tool of 2 mm does not fit into the pocket at (40, 0); use one "
                "of 1.499 mm or less"));
  EXPECT_THAT(ClearPocket(Irregular(), {2, 1.5}).error().message,
              HasSubstr("the step is 1.5"));
}

// By hand: (1 - pi / 4) r^2 in each inner corner.
TEST(Unreached, HasTheCornersOfARectangle) {
  const auto corners = Unreached(Area({Rectangle({0, 0}, {30, 20})}), 2);
  ASSERT_TRUE(corners) << corners.error().message;
  EXPECT_NEAR(AreaOf(*corners), 4 - pi, 1e-5);
  EXPECT_EQ(corners->loops.size(), 4U);
}

// The pocket around all pads and tracks of a board, without what they enclose.
TEST(Pocket, ClearsAroundThePadsOfABoard) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const auto drawn = Unite(test::MakeBoard({25, seed, seed % 2 == 0}));
    ASSERT_TRUE(drawn);
    std::vector<Edges> loops{Rectangle({-4, -4}, {16, 16})};
    for (const Contour& contour : drawn->contours) loops.push_back(contour.edges);
    const auto all = RegionOfLoops(loops);
    ASSERT_TRUE(all) << all.error().message;
    const Region area = ConnectedParts(*all)[0];
    const auto pocket = ClearPocket(area, {0.4, seed % 3 == 0 ? 0.45 : 0.7});
    ASSERT_TRUE(pocket) << pocket.error().message;
    if (const auto left = Unreached(area, 0.4)) {
      EXPECT_NEAR(pocket->left_area_mm2, AreaOf(*left), 1e-4);
    }
    EXPECT_LT(pocket->left_area_mm2, 0.05 * AreaOf(area));
  }
}

}  // namespace
}  // namespace intaglio::contour
