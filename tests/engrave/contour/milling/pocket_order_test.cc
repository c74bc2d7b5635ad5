#include "engrave/contour/milling/pocket_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "engrave/contour/union.h"
#include "tests/engrave/contour/boards.h"

namespace intaglio::contour {
namespace {

Edges Box(const Vec2& a, const Vec2& b) {
  return {MakeLine(a, {b.x(), a.y()}), MakeLine({b.x(), a.y()}, b),
          MakeLine(b, {a.x(), b.y()}), MakeLine({a.x(), b.y()}, a)};
}

/// A plate of 60 x 40 mm with a square, a disc and a slanted island.
Region Islands() {
  const auto region =
      RegionOfLoops({Box({0, 0}, {60, 40}),
                     Box({8, 9}, {18, 20}),
                     {MakeArc({40, 12}, 6, 0, 2 * std::numbers::pi)},
                     {MakeLine({30, 25}, {44, 30}), MakeLine({44, 30}, {34, 35}),
                      MakeLine({34, 35}, {30, 25})}});
  EXPECT_TRUE(region) << region.error().message;
  return *region;
}

double IdleOf(const std::vector<PocketStep>& steps, Vec2 at) {
  double sum = 0;
  for (const PocketStep& step : steps) {
    sum += (step.path.front().begin_mm - at).norm();
    at = step.path.back().end_mm;
  }
  return sum;
}

/// Pass by pass, each path from its first corner.
std::vector<PocketStep> InRows(const Pocket& pocket) {
  std::vector<PocketStep> steps;
  for (std::uint32_t pass = 0; pass < pocket.passes.size(); ++pass) {
    for (const Edges& path : pocket.passes[pass].paths) steps.push_back({path, pass});
  }
  return steps;
}

/// Every path once, closed, with its length and area.
void ExpectSamePaths(const Pocket& pocket, const std::vector<PocketStep>& steps) {
  const auto figures = [](const std::vector<PocketStep>& all) {
    std::vector<std::pair<std::uint32_t, Vec2>> made;
    for (const PocketStep& step : all)
      made.emplace_back(step.pass, Vec2(LengthOf(step.path), AreaOf(step.path)));
    std::sort(made.begin(), made.end(), [](const auto& a, const auto& b) {
      return std::pair(a.first, a.second.x()) < std::pair(b.first, b.second.x());
    });
    return made;
  };
  const auto expected = figures(InRows(pocket)), found = figures(steps);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_EQ(found[k].first, expected[k].first);
    EXPECT_NEAR(found[k].second.x(), expected[k].second.x(), 1e-6);
  }
  for (const PocketStep& step : steps) {
    EXPECT_LT((step.path.front().begin_mm - step.path.back().end_mm).norm(), 1e-9);
    for (std::size_t k = 1; k < step.path.size(); ++k)
      EXPECT_LT((step.path[k].begin_mm - step.path[k - 1].end_mm).norm(), 1e-6);
  }
}

double NearestOf(const Edges& path, const Vec2& place) {
  double nearest = 1e300;
  for (const Edge& edge : path) nearest = std::min(nearest, DistanceTo(edge, place));
  return nearest;
}

/// Checks points everywhere on each path: what lies beside them towards the wall, in the
/// next pass that goes all around, is made later.
void ExpectTowardsTheWall(const Pocket& pocket, const std::vector<PocketStep>& steps) {
  for (std::size_t late = 0; late < steps.size(); ++late) {
    const double deep_mm = pocket.passes[steps[late].pass].offset_mm;
    std::uint32_t next = steps[late].pass + 1;
    while (next < pocket.passes.size() && pocket.passes[next].between) ++next;
    for (std::size_t early = 0; early < late; ++early) {
      const std::uint32_t pass = steps[early].pass;
      if (pass <= steps[late].pass || pass > next) continue;
      const double apart_mm = deep_mm - pocket.passes[pass].offset_mm;
      for (const Edge& edge : steps[late].path) {
        for (int k = 0; k < 8; ++k) {
          const Vec2 place = PointAt(edge, (k + 0.5) / 8 * edge.length_mm);
          EXPECT_GT(NearestOf(steps[early].path, place), apart_mm + 1e-5)
              << "step " << late << " is deeper than step " << early;
        }
      }
    }
  }
}

TEST(PocketOrder, ClearsEachPartToItsEnd) {
  for (const double step : {0.3, 0.45, 0.7}) {
    SCOPED_TRACE(step);
    const auto pocket = ClearPocket(Islands(), {2, step});
    ASSERT_TRUE(pocket) << pocket.error().message;
    const auto steps = OrderPocket(*pocket, {0, 0});
    ExpectSamePaths(*pocket, steps);
    ExpectTowardsTheWall(*pocket, steps);
    // By hand: a step from each path to the next one of its part, and of the parts' ways
    // from one to another none is longer than the plate.
    const double idle_mm = IdleOf(steps, {0, 0}),
                 rows_mm = IdleOf(InRows(*pocket), {0, 0});
    EXPECT_LT(idle_mm, 0.5 * rows_mm);
    RecordProperty("idle_um", static_cast<int>(1e3 * idle_mm));
    RecordProperty("rows_um", static_cast<int>(1e3 * rows_mm));
  }
}

TEST(PocketOrder, OfBoardsIsNeverLongerThanRows) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    SCOPED_TRACE(seed);
    const auto drawn = Unite(test::MakeBoard({20, seed, seed % 2 == 0}));
    ASSERT_TRUE(drawn);
    std::vector<Edges> loops{Box({-4, -4}, {16, 16})};
    for (const Contour& contour : drawn->contours) loops.push_back(contour.edges);
    const auto all = RegionOfLoops(loops);
    ASSERT_TRUE(all) << all.error().message;
    const auto pocket =
        ClearPocket(ConnectedParts(*all)[0], {0.6, seed % 3 == 0 ? 0.45 : 0.7});
    ASSERT_TRUE(pocket) << pocket.error().message;
    const auto steps = OrderPocket(*pocket, {0, 0});
    ExpectSamePaths(*pocket, steps);
    ExpectTowardsTheWall(*pocket, steps);
    EXPECT_LT(IdleOf(steps, {0, 0}), IdleOf(InRows(*pocket), {0, 0}));
  }
}

TEST(PocketOrder, OfNothingIsEmpty) { EXPECT_TRUE(OrderPocket({}, {0, 0}).empty()); }

}  // namespace
}  // namespace intaglio::contour
