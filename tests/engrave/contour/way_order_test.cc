#include "engrave/contour/way_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <sstream>

#include "tests/engrave/contour/boards.h"
#include "tests/engrave/contour/tables.h"

namespace intaglio::contour {
namespace {

std::vector<Vec2> RandomPlaces(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Vec2> places;
  for (int k = 0; k < count; ++k) {
    const double x = 100 * test::Random(random);
    places.push_back({x, 100 * test::Random(random)});
  }
  return places;
}

/// Holes on a raster of 1.27 mm, half of it empty, as of a board.
std::vector<Vec2> RasterPlaces(int side, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Vec2> places;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      if (test::Random(random) < 0.35) places.push_back(1.27 * Vec2(x, y));
    }
  }
  return places;
}

bool IsPermutation(VisitOrder order, std::size_t count) {
  std::sort(order.begin(), order.end());
  VisitOrder all(count);
  std::iota(all.begin(), all.end(), 0U);
  return order == all;
}

// Siwiec 2016, annex C: from the origin, two choices between equal distances.
TEST(NearestOrder, IsThatOfThePublishedHoles) {
  const auto table = test::Table("krl_drill.csv");
  ASSERT_EQ(table.rows.size(), 20U);
  std::vector<Vec2> places;
  for (const auto& row : table.rows)
    places.push_back({test::NumberOf(table, row, "x"), test::NumberOf(table, row, "y")});
  // Given in another order.
  std::vector<Vec2> mixed;
  for (std::size_t k = 0; k < places.size(); ++k) mixed.push_back(places[7 * k % 20]);
  const VisitOrder order = NearestOrder(mixed, Vec2::Zero());
  for (std::size_t k = 0; k < places.size(); ++k)
    EXPECT_EQ(mixed[order[k]], places[k]) << k;
}

// Siwiec 2016, figure 8.1, from every start: 15 to 17 steps.
TEST(NearestOrder, IsThatOfThePublishedGrid) {
  std::vector<Vec2> grid;
  for (int k = 0; k < 16; ++k) grid.push_back({k % 4, k / 4});
  const auto table = test::Table("grid_4x4.csv");
  ASSERT_EQ(table.rows.size(), 16U);
  for (const auto& row : table.rows) {
    const Vec2 start(test::NumberOf(table, row, "start_x"),
                     test::NumberOf(table, row, "start_y"));
    VisitOrder order = NearestOrder(grid, start);
    std::istringstream printed(row.fields[3]);
    for (const std::uint32_t k : order) {
      std::uint32_t expected = 0;
      printed >> expected;
      EXPECT_EQ(k, expected) << row.fields[3];
    }
    // The table has three decimals.
    const double way = IdleWay_mm(grid, start, order);
    EXPECT_NEAR(way, test::NumberOf(table, row, "unit_moves"), 5e-4);
    ImproveOrder(grid, start, order);
    EXPECT_LE(IdleWay_mm(grid, start, order), way);
    EXPECT_EQ(order.size(), 16U);
  }
}

// The optimum of small sets by trying all orders.
TEST(ImprovedOrder, IsTheShortestOfEightPlaces) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const auto places = RandomPlaces(8, seed);
    VisitOrder all(8);
    std::iota(all.begin(), all.end(), 0U);
    double shortest = 1e300;
    do {
      shortest = std::min(shortest, IdleWay_mm(places, Vec2::Zero(), all));
    } while (std::next_permutation(all.begin(), all.end()));
    VisitOrder order = NearestOrder(places, Vec2::Zero());
    ImproveOrder(places, Vec2::Zero(), order);
    EXPECT_NEAR(IdleWay_mm(places, Vec2::Zero(), order), shortest, 1e-9) << seed;
  }
}

TEST(ImprovedOrder, SavesTwelveHundredthsOfTheNearestOrdersWay) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    for (const auto& places : {RandomPlaces(500, seed), RasterPlaces(40, seed)}) {
      VisitOrder order = NearestOrder(places, Vec2::Zero());
      const double nearest = IdleWay_mm(places, Vec2::Zero(), order);
      ImproveOrder(places, Vec2::Zero(), order);
      ASSERT_TRUE(IsPermutation(order, places.size()));
      EXPECT_LT(IdleWay_mm(places, Vec2::Zero(), order), 0.88 * nearest)
          << places.size() << " places, seed " << seed;
    }
  }
}

TEST(ImprovedOrder, IsTheSameEachTime) {
  const auto places = RandomPlaces(200, 9);
  VisitOrder a = NearestOrder(places, Vec2::Zero());
  VisitOrder b = a;
  ImproveOrder(places, Vec2::Zero(), a);
  ImproveOrder(places, Vec2::Zero(), b);
  EXPECT_EQ(a, b);
}

TEST(ImprovedOrder, OfOneOrNoPlaceOrOfEqualPlacesIsAPermutation) {
  for (const std::size_t count : {0U, 1U, 2U, 20U}) {
    const std::vector<Vec2> places(count, Vec2(1, 2));
    VisitOrder order = NearestOrder(places, Vec2::Zero());
    ImproveOrder(places, Vec2::Zero(), order);
    EXPECT_TRUE(IsPermutation(order, count));
  }
}

}  // namespace
}  // namespace intaglio::contour
