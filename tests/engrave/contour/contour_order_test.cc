#include "engrave/contour/contour_order.h"

#include <gtest/gtest.h>

#include <numbers>
#include <set>

#include "tests/engrave/contour/boards.h"

namespace intaglio::contour {
namespace {

Union Board(int count, unsigned seed, bool free_angles) {
  auto united = Unite(test::MakeBoard({count, seed, free_angles}), {0.1});
  EXPECT_TRUE(united) << united.error().message;
  return united ? *united : Union{};
}

TEST(ContourOrder, BeginsAtTheNearestCornerAndVisitsEachContourOnce) {
  const Union board = Board(100, 4, true);
  const auto visits = NearestContours(board.contours, Vec2::Zero());
  std::set<std::uint32_t> seen;
  for (const ContourVisit& visit : visits) seen.insert(visit.contour);
  EXPECT_EQ(visits.size(), board.contours.size());
  EXPECT_EQ(seen.size(), board.contours.size());
  double nearest = 1e300;
  for (const Contour& contour : board.contours) {
    for (const Edge& edge : contour.edges)
      nearest = std::min(nearest, edge.begin_mm.norm());
  }
  EXPECT_NEAR(IdleWay_mm(board.contours, Vec2::Zero(), {visits.data(), 1}), nearest,
              1e-12);
}

TEST(ContourOrder, SavesEighteenHundredthsOfTheNearestOrdersWay) {
  for (const bool free_angles : {false, true}) {
    for (unsigned seed = 1; seed <= 2; ++seed) {
      const Union board = Board(1000, seed, free_angles);
      auto visits = NearestContours(board.contours, Vec2::Zero());
      const double nearest = IdleWay_mm(board.contours, Vec2::Zero(), visits);
      ImproveContours(board.contours, Vec2::Zero(), visits);
      std::set<std::uint32_t> seen;
      for (const ContourVisit& visit : visits) seen.insert(visit.contour);
      EXPECT_EQ(seen.size(), board.contours.size());
      EXPECT_LT(IdleWay_mm(board.contours, Vec2::Zero(), visits), 0.82 * nearest)
          << board.contours.size() << " contours, seed " << seed;
    }
  }
}

// Two circles in a row: the tool enters each where the straight way meets it.
TEST(ContourOrder, EntersWhereTheWayIsShortest) {
  const auto united =
      Unite(std::vector<Element>{{Circle{{5, 0}, 2}, ""}, {Circle{{10, 0}, 2}, ""}});
  ASSERT_TRUE(united);
  auto visits = NearestContours(united->contours, Vec2::Zero());
  ImproveContours(united->contours, Vec2::Zero(), visits);
  EXPECT_NEAR(IdleWay_mm(united->contours, Vec2::Zero(), visits), 9, 1e-3);
}

TEST(EdgesFrom, AnEntryRunOnceAroundTheContour) {
  const Union board = Board(60, 2, true);
  for (const Contour& contour : board.contours) {
    const auto middle = static_cast<std::uint32_t>(contour.edges.size() / 2);
    for (const double part : {0.0, 0.3}) {
      const double way = part * contour.edges[middle].length_mm;
      const Edges edges = EdgesFrom(contour.edges, {0, middle, way});
      EXPECT_NEAR(AreaOf(edges), contour.area_mm2, 1e-9);
      EXPECT_NEAR(LengthOf(edges), contour.length_mm, 1e-9);
      EXPECT_LT((edges.front().begin_mm - edges.back().end_mm).norm(), 1e-9);
      EXPECT_LT((edges.front().begin_mm - PointAt(contour.edges[middle], way)).norm(),
                1e-9);
    }
  }
}

}  // namespace
}  // namespace intaglio::contour
