#include "engrave/contour/near_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <limits>
#include <random>
#include <set>

#include "engrave/contour/edge_tree.h"
#include "engrave/contour/simple_loops.h"
#include "engrave/contour/union.h"

namespace intaglio::contour {
namespace {

using Pairs = std::set<std::pair<std::uint32_t, std::uint32_t>>;

Pairs PairsByAll(const std::vector<FlatBox>& boxes, double margin_mm) {
  Pairs pairs;
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    for (std::uint32_t j = i + 1; j < boxes.size(); ++j) {
      const Vec2 min = boxes[i].min_mm.cwiseMax(boxes[j].min_mm);
      const Vec2 max = boxes[i].max_mm.cwiseMin(boxes[j].max_mm);
      if (min.x() <= max.x() + margin_mm && min.y() <= max.y() + margin_mm)
        pairs.insert({i, j});
    }
  }
  return pairs;
}

Pairs PairsByGrid(const std::vector<FlatBox>& boxes, double margin_mm) {
  Pairs pairs;
  for (const Pair& pair : NearPairs(boxes, margin_mm))
    EXPECT_TRUE(pairs.insert({pair.first, pair.second}).second);
  return pairs;
}

// Boxes on an exact grid end on the lines of the grid of cells, where the cell of an end
// and the number of cells used to round to different numbers: a write beyond the heap.
TEST(NearPairs, FindsAllOnExactGrids) {
  std::mt19937 random(14);
  std::uniform_int_distribution<int> microns(1, 4000), counts(1, 6);
  for (int k = 0; k < 20'000; ++k) {
    const double pitch = microns(random) * 1e-3, side = microns(random) * 1e-3;
    const double margin = k % 3 == 0 ? 0 : k % 3 == 1 ? 1e-3 : microns(random) * 1e-3;
    const int columns = counts(random), rows = counts(random);
    std::vector<FlatBox> boxes;
    for (int x = 0; x < columns; ++x) {
      for (int y = 0; y < rows; ++y) {
        const Vec2 at(x * pitch, y * pitch);
        boxes.push_back({at - Vec2::Constant(side / 2), at + Vec2::Constant(side / 2)});
      }
    }
    ASSERT_EQ(PairsByGrid(boxes, margin), PairsByAll(boxes, margin))
        << columns << " x " << rows << ", pitch " << pitch << ", side " << side
        << ", margin " << margin;
  }
}

/// A star with this many corners, lines and arcs in turn.
Edges Star(int corners, std::mt19937& random) {
  std::uniform_real_distribution<double> radius(5, 10);
  std::vector<Vec2> places;
  for (int k = 0; k < corners; ++k) {
    const double angle = 2 * M_PI * k / corners;
    places.push_back(radius(random) * Vec2(std::cos(angle), std::sin(angle)));
  }
  Edges edges;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const Vec2 &a = places[k], &b = places[(k + 1) % places.size()];
    const Vec2 off = 3 * RightOf((b - a).normalized());
    if (k % 3 == 0)
      edges.push_back(MakeArcBetween(a, b, 0.5 * (a + b) + off, k % 2 == 0));
    else
      edges.push_back(MakeLine(a, b));
  }
  return edges;
}

// The tree answers what a walk over all edges answers.
TEST(EdgeTree, IsTheSumOfItsEdges) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> place(-14, 14);
  for (const int corners : {3, 9, 40, 700}) {
    const Edges edges = Star(corners, random);
    const EdgeTree tree(edges);
    for (int k = 0; k < 3000; ++k) {
      // Every tenth at the height of a corner.
      Vec2 at(place(random), place(random));
      if (k % 10 == 0)
        at.y() = edges[static_cast<std::size_t>(k) % edges.size()].begin_mm.y();
      double nearest = 1e9;
      for (const Edge& edge : edges) nearest = std::min(nearest, DistanceTo(edge, at));
      EXPECT_EQ(tree.DistanceTo(at), nearest);
      EXPECT_EQ(tree.IsInside(at), IsInLoops(edges, at)) << corners << " " << k;
    }
    EXPECT_EQ(tree.EdgesIn({{-99, -99}, {99, 99}}).size(), edges.size());
    EXPECT_TRUE(tree.EdgesIn({{60, 60}, {70, 70}}).empty());
  }
}

double SecondsOfOutline(int corners) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> radius(39.85, 40.15);
  Edges loop;
  std::vector<Vec2> places;
  for (int k = 0; k < corners; ++k) {
    const double angle = 2 * M_PI * k / corners;
    places.push_back(radius(random) * Vec2(std::cos(angle), std::sin(angle)));
  }
  for (std::size_t k = 0; k < places.size(); ++k)
    loop.push_back(MakeLine(places[k], places[(k + 1) % places.size()]));
  const std::clock_t begin = std::clock();
  EXPECT_TRUE(Unite(std::vector<Element>{{Outline{{loop}}}}, {0.1, Corners::kRound}));
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

// Processor time of 4 x as many edges is about 4.5 x, and not 16 x. Neighbours on a busy
// computer take some of a processor's caches, not in each of ten runs.
TEST(Union, OfALargeOutlineGrowsAsItsEdges) {
  double lowest_ratio = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 10 && lowest_ratio > 9; ++i)
    lowest_ratio =
        std::min(lowest_ratio, SecondsOfOutline(6000) / (SecondsOfOutline(1500) + 1e-9));
  EXPECT_LE(lowest_ratio, 9);
}

// What is drawn again is one element: with 3000 of them pairs alone are 4.5 million.
TEST(Union, OfEqualElementsIsOne) {
  std::vector<Element> elements;
  for (int k = 0; k < 3000; ++k) {
    const Vec2 a(0, 0), b(5, 0);
    elements.push_back({Track{k % 2 == 0 ? a : b, k % 2 == 0 ? b : a, 0.5}, "GND"});
    elements.push_back({Circle{{0, 4}, 1}, "VCC"});
  }
  const auto united = Unite(elements, {0.1, Corners::kRound});
  ASSERT_TRUE(united);
  EXPECT_EQ(united->contours.size(), 2U);
  EXPECT_EQ(united->group_count, 2U);
  ASSERT_EQ(united->groups.size(), elements.size());
  for (std::size_t k = 0; k < elements.size(); ++k) EXPECT_EQ(united->groups[k], k % 2);
  EXPECT_NEAR(united->area_mm2, 5 * 0.7 + M_PI * 0.35 * 0.35 + M_PI * 0.6 * 0.6, 1e-9);
}

// Spokes of 45 mm side by side: their boxes meet nearly all, gigabytes of pairs.
TEST(Union, OfTooManyLongEdgesSideBySideIsRefusedSoon) {
  Edges star;
  constexpr int kCorners = 80'000;
  const auto corner = [](int k) {
    const double angle = 2 * M_PI * k / kCorners;
    return (k % 2 == 0 ? 5.0 : 50.0) * Vec2(std::cos(angle), std::sin(angle));
  };
  for (int k = 0; k < kCorners; ++k) star.push_back(MakeLine(corner(k), corner(k + 1)));
  star.back().end_mm = star.front().begin_mm;
  const std::clock_t begin = std::clock();
  const auto loops = OrientedLoops({star});
  ASSERT_FALSE(loops);
  EXPECT_EQ(loops.error().code, ErrorCode::kTooLarge);
  EXPECT_NE(loops.error().message.find("of 80000 edges"), std::string::npos);
  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 10);
}

}  // namespace
}  // namespace intaglio::contour
