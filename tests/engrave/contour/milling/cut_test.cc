#include "engrave/contour/milling/cut.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

namespace intaglio::contour {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;

Edges Sheet(const Vec2& a, const Vec2& b) {
  return {MakeLine(a, {b.x(), a.y()}), MakeLine({b.x(), a.y()}, b),
          MakeLine(b, {a.x(), b.y()}), MakeLine({a.x(), b.y()}, a)};
}

Region Part(const std::vector<Edges>& loops) {
  const auto region = RegionOfLoops(loops);
  EXPECT_TRUE(region) << region.error().message;
  return region ? *region : Region{};
}

/// A plate of 60 x 40 with a round hole and a slot.
Region Plate() {
  return Part({Sheet({0, 0}, {60, 40}),
               {MakeArc({15, 20}, 6, 0, 2 * pi)},
               Sheet({30, 10}, {50, 20})});
}

std::vector<Cut> CutsOf(const Region& area, const CutOptions& options) {
  auto cuts = CutOut(area, options);
  EXPECT_TRUE(cuts) << cuts.error().message;
  return cuts ? *cuts : std::vector<Cut>{};
}

std::string RefusalOfCut(const Region& area, const CutOptions& options) {
  const auto cuts = CutOut(area, options);
  return cuts ? "no error" : cuts.error().message;
}

/// Signed: negative inside the area.
double DistanceTo(const Region& area, const Vec2& p) {
  double nearest = 1e300;
  for (const Edges& loop : area.loops) {
    for (const Edge& edge : loop) nearest = std::min(nearest, DistanceTo(edge, p));
  }
  return IsInside(area, p) ? -nearest : nearest;
}

/// The nearest and the farthest point of edges, by samples.
std::pair<double, double> Distances(const Region& area, const Edges& edges) {
  std::pair<double, double> found{1e300, -1e300};
  for (const Edge& edge : edges) {
    for (int k = 0; k <= 50; ++k) {
      const double d = DistanceTo(area, PointAt(edge, k / 50.0 * edge.length_mm));
      found = {std::min(found.first, d), std::max(found.second, d)};
    }
  }
  return found;
}

Edges Closed(const Cut& cut) {
  Edges edges;
  for (const CutPiece& piece : cut.pieces) edges.push_back(piece.edge);
  return edges;
}

TEST(Cut, RunsBesideTheContourOnTheSideOfTheWaste) {
  for (const double tool : {0.1, 2.0, 6.0}) {
    const auto cuts = CutsOf(Plate(), {tool});
    ASSERT_EQ(cuts.size(), 3U);
    EXPECT_TRUE(cuts[0].inner);
    EXPECT_TRUE(cuts[1].inner);
    EXPECT_FALSE(cuts[2].inner);
    for (const Cut& cut : cuts) {
      const auto [nearest, farthest] = Distances(Plate(), Closed(cut));
      EXPECT_NEAR(nearest, tool / 2, 1e-5);
      EXPECT_NEAR(farthest, tool / 2, 1e-5);
    }
    // Around corners the tool rolls; into corners it goes straight.
    EXPECT_NEAR(LengthOf(Closed(cuts[2])), 200 + pi * tool, 1e-5);
    EXPECT_NEAR(LengthOf(Closed(cuts[0])), pi * (12 - tool), 1e-5);
    EXPECT_NEAR(LengthOf(Closed(cuts[1])), 60 - 4 * tool, 1e-5);
  }
}

TEST(Cut, OfOpeningsRunsInside) {
  const auto cuts = CutsOf(Part({Sheet({0, 0}, {30, 20}), Sheet({10, 8}, {20, 12})}),
                           {2, CutSide::kInside});
  ASSERT_EQ(cuts.size(), 2U);
  EXPECT_FALSE(cuts[0].inner);  // around the island
  EXPECT_TRUE(cuts[1].inner);
  EXPECT_NEAR(LengthOf(Closed(cuts[0])), 28 + 2 * pi, 1e-5);
  EXPECT_NEAR(LengthOf(Closed(cuts[1])), 100 - 8, 1e-5);
}

TEST(Cut, ClimbingKeepsWhatStaysToTheRight) {
  for (const CutSide side : {CutSide::kOutside, CutSide::kInside}) {
    for (const CutDirection direction :
         {CutDirection::kClimb, CutDirection::kConventional}) {
      for (const Cut& cut : CutsOf(Plate(), {2, side, direction})) {
        const Edge& edge = cut.pieces[0].edge;
        const double middle = edge.length_mm / 2;
        const Vec2 right =
            PointAt(edge, middle) + 1.5 * RightOf(DirectionAt(edge, middle));
        const bool stays = IsInside(Plate(), right) == (side == CutSide::kOutside);
        EXPECT_EQ(stays, direction == CutDirection::kClimb);
      }
    }
  }
}

TEST(Cut, LeadsBeginInTheWasteAndNeverCutWhatStays) {
  for (const LeadKind lead : {LeadKind::kLine, LeadKind::kArc}) {
    for (const CutSide side : {CutSide::kOutside, CutSide::kInside}) {
      const CutOptions options{2, side, CutDirection::kClimb, lead, 1.5};
      const auto cuts = CutsOf(Plate(), options);
      ASSERT_EQ(cuts.size(), 3U);
      for (const Cut& cut : cuts) {
        ASSERT_EQ(cut.lead_in.size(), 1U);
        const Edges path = PathOf(cut);
        for (std::size_t k = 1; k < path.size(); ++k)
          EXPECT_LT((path[k].begin_mm - path[k - 1].end_mm).norm(), 1e-9);
        EXPECT_LT((cut.lead_in[0].end_mm - cut.lead_out[0].begin_mm).norm(), 1e-9);
        for (const Edges& edges : {cut.lead_in, cut.lead_out}) {
          auto [nearest, farthest] = Distances(Plate(), edges);
          if (side == CutSide::kInside) nearest = -std::exchange(farthest, -nearest);
          EXPECT_GT(nearest, 1 - 1e-5);
          EXPECT_GT(farthest, 1.5);
        }
        if (lead == LeadKind::kLine) continue;
        const Edge& in = cut.lead_in[0];
        EXPECT_NEAR(DirectionAt(in, in.length_mm).dot(DirectionAt(cut.pieces[0].edge, 0)),
                    1, 1e-9);
      }
    }
  }
}

TEST(Cut, TabsAreSpreadOverStraightPieces) {
  CutOptions options{2};
  options.tabs.count = 4;
  const auto cuts = CutsOf(Plate(), options);
  EXPECT_TRUE(cuts[0].tabs_mm.empty());
  ASSERT_EQ(cuts[2].tabs_mm.size(), 4U);
  double tabs = 0;
  for (const CutPiece& piece : cuts[2].pieces) {
    if (!piece.tab) continue;
    EXPECT_FALSE(piece.edge.is_arc());
    tabs += piece.edge.length_mm;
  }
  // The tool's centre is up for the width and its own diameter.
  EXPECT_NEAR(tabs, 4 * (3 + 2), 1e-5);
  EXPECT_NEAR(LengthOf(Closed(cuts[2])), 200 + 2 * pi, 1e-5);
  // One in each quarter of the way.
  double way = 0;
  std::vector<double> ways;
  for (const CutPiece& piece : cuts[2].pieces) {
    if (piece.tab) ways.push_back(way + piece.edge.length_mm / 2);
    way += piece.edge.length_mm;
  }
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(ways[k], (static_cast<double>(k) + 0.5) / 4 * way, 4);
}

// As many as fit by hand: a side of 60 holds 12 of 5 mm, one of 40 holds 8.
TEST(Cut, TabsThatDoNotFitAreRefused) {
  CutOptions options{2};
  options.tabs.count = 40;
  const auto cuts = CutsOf(Part({Sheet({0, 0}, {60.1, 40.1})}), options);
  ASSERT_EQ(cuts.size(), 1U);
  EXPECT_EQ(cuts[0].tabs_mm.size(), 40U);
  options.tabs.count = 41;
  EXPECT_THAT(RefusalOfCut(Part({Sheet({0, 0}, {60.1, 40.1})}), options),
              HasSubstr("hold 40 of 41 tabs of 3 mm"));
  options.tabs.of_holes = true;
  options.tabs.count = 1;
  // The tool runs on 5 mm in the round hole: too tight an arc for 4 mm and the tool.
  options.tabs.width_mm = 4;
  EXPECT_THAT(RefusalOfCut(Plate(), options), HasSubstr("hold 0 of 1 tab "));
}

// A round part has no straight piece. What the tool leaves between its two discs at the
// ends of a tab is measured by their distance.
TEST(Cut, RoundPartsHaveTabsOnTheirArcs) {
  const Vec2 center(7, -3);
  CutOptions options{2};
  options.tabs.count = 3;
  const auto cuts = CutsOf(Part({{MakeArc(center, 10, 0, 2 * pi)}}), options);
  ASSERT_EQ(cuts.size(), 1U);
  ASSERT_EQ(cuts[0].tabs_mm.size(), 3U);
  for (const CutPiece& piece : cuts[0].pieces) {
    EXPECT_NEAR((piece.edge.begin_mm - center).norm(), 11, 1e-9);
    if (!piece.tab) continue;
    EXPECT_NEAR((piece.edge.end_mm - piece.edge.begin_mm).norm() - 2, 3, 1e-9);
  }
  EXPECT_NEAR(LengthOf(Closed(cuts[0])), 2 * pi * 11, 1e-6);
  for (std::size_t k = 0; k < 3; ++k) {
    const double apart = (cuts[0].tabs_mm[k] - cuts[0].tabs_mm[(k + 1) % 3]).norm();
    EXPECT_NEAR(apart, 11 * std::sqrt(3.0), 1e-6) << "a third of a turn";
  }
}

TEST(Cut, RefusesWhatTheToolCannotCut) {
  EXPECT_THAT(RefusalOfCut(Plate(), {13}),
              HasSubstr("the tool of 13 mm does not fit into the contour at (21, 20)"));
  EXPECT_THAT(
      RefusalOfCut(Part({Sheet({0, 0}, {10, 10}), Sheet({11, 0}, {20, 10})}), {1.5}),
      HasSubstr("nearer to each other than the tool of 1.5 mm"));
  // Two bays joined by a neck of 1 mm.
  const Edges bays{
      MakeLine({0, 0}, {10, 0}),  MakeLine({10, 0}, {10, 4}), MakeLine({10, 4}, {15, 4}),
      MakeLine({15, 4}, {15, 0}), MakeLine({15, 0}, {25, 0}), MakeLine({25, 0}, {25, 9}),
      MakeLine({25, 9}, {15, 9}), MakeLine({15, 9}, {15, 5}), MakeLine({15, 5}, {10, 5}),
      MakeLine({10, 5}, {10, 9}), MakeLine({10, 9}, {0, 9}),  MakeLine({0, 9}, {0, 0})};
  EXPECT_THAT(RefusalOfCut(Part({bays}), {2, CutSide::kInside}),
              HasSubstr("does not pass the neck"));
  const CutOptions long_lead{2, CutSide::kOutside, CutDirection::kClimb, LeadKind::kArc,
                             20};
  EXPECT_THAT(RefusalOfCut(Plate(), long_lead), HasSubstr("a lead of 20 mm would cut"));
  EXPECT_THAT(RefusalOfCut(Plate(), {0}), HasSubstr("the tool's diameter is 0"));
}

}  // namespace
}  // namespace intaglio::contour
