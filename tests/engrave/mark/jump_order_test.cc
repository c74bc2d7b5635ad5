#include "engrave/mark/jump_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace intaglio::mark {
namespace {

std::vector<Mark> RandomMarks(std::size_t count, std::mt19937& random) {
  std::uniform_real_distribution<double> place(0, 50);
  std::vector<Mark> marks;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec2 a(place(random), place(random)), b = a + Vec2(place(random), 1) / 20;
    marks.push_back({0, false, 0, {{a, 0.1}, {b, -0.2}, {b + Vec2(0, 1), 0}}});
    if (i % 3 == 0) marks.back().closed = true;
  }
  return marks;
}

/// What a mark is, whatever its direction and its first place: its length and extent.
std::vector<double> Contents(const std::vector<Mark>& marks) {
  std::vector<double> contents;
  for (const Mark& mark : marks) {
    Vec2 sum = Vec2::Zero();
    for (const Place& p : mark.places) sum += p.at_mm;
    contents.push_back(std::round(1e6 * (LengthOf(mark) + 100 * sum.x() + sum.y())));
  }
  std::ranges::sort(contents);
  return contents;
}

TEST(JumpOrder, KeepsEveryMarkAndIsShorter) {
  std::mt19937 random(11);
  for (const std::size_t count : {1U, 2U, 10U, 400U, 3000U}) {
    const auto marks = RandomMarks(count, random);
    for (const bool may_reverse : {true, false}) {
      const auto ordered = OrderByJumps(marks, {Vec2(0, 0), may_reverse});
      EXPECT_EQ(Contents(ordered), Contents(marks));
      EXPECT_LE(JumpLength(ordered, {0, 0}), JumpLength(marks, {0, 0}));
      if (count >= 400) {
        EXPECT_LT(JumpLength(ordered, {0, 0}), JumpLength(marks, {0, 0}) / 5);
      }
    }
  }
}

TEST(JumpOrder, KeepsDirectionsWhenItMayNotReverse) {
  std::mt19937 random(12);
  for (const Mark& mark : OrderByJumps(RandomMarks(300, random), {Vec2(0, 0), false})) {
    EXPECT_TRUE(mark.closed || mark.places[0].at_mm.x() < mark.places[1].at_mm.x());
  }
}

/// The shortest way through straight marks, all orders and directions tried.
double ShortestOf(const std::vector<Mark>& marks) {
  std::vector<std::size_t> order(marks.size());
  std::iota(order.begin(), order.end(), 0U);
  double shortest = std::numeric_limits<double>::infinity();
  do {
    for (unsigned turned = 0; turned < 1U << marks.size(); ++turned) {
      Vec2 from = Vec2::Zero();
      double length = 0;
      for (const std::size_t i : order) {
        Vec2 a = marks[i].places.front().at_mm, b = marks[i].places.back().at_mm;
        if ((turned >> i & 1) != 0) std::swap(a, b);
        length += (a - from).norm();
        from = b;
      }
      shortest = std::min(shortest, length);
    }
  } while (std::ranges::next_permutation(order).found);
  return shortest;
}

TEST(JumpOrder, IsNearTheShortestOfAll) {
  std::mt19937 random(13);
  std::uniform_real_distribution<double> place(0, 50);
  double sum = 0, shortest = 0;
  for (int k = 0; k < 12; ++k) {
    std::vector<Mark> marks;
    for (int i = 0; i < 6; ++i)
      marks.push_back(
          {0,
           false,
           0,
           {{{place(random), place(random)}, 0}, {{place(random), place(random)}, 0}}});
    const double best = ShortestOf(marks);
    const double is = JumpLength(OrderByJumps(marks, {}), {0, 0});
    EXPECT_GE(is, best - 1e-9);
    EXPECT_LE(is, 1.5 * best);
    sum += is, shortest += best;
  }
  // Nearest alone ends about 25 % above the shortest.
  EXPECT_LE(sum, 1.12 * shortest);
}

TEST(JumpOrder, AReversedRowHasTheSameDots) {
  // A dot of 1, a gap of 1 and a dot of 3 mm; the nearest end is the last one.
  const Mark row{0, false, 0, {{{0, 0}}, {{1, 0}, 0, true}, {{2, 0}}, {{5, 0}}}};
  const auto ordered = OrderByJumps({row}, {Vec2(6, 0), true});
  const auto dots = LitWaysOf(ordered.front(), 0.001);
  ASSERT_EQ(dots.size(), 2U);
  EXPECT_EQ(dots[0], (std::vector<Vec2>{{5, 0}, {2, 0}}));
  EXPECT_EQ(dots[1], (std::vector<Vec2>{{1, 0}, {0, 0}}));
  EXPECT_TRUE(CheckMarks({{{"pen", 100, 0.5}}, ordered}));
}

TEST(JumpOrder, AReversedArcIsTheSameArc) {
  const Mark arc{0, false, 0, {{{10, 0}, 0.5}, {{5, 2}, 0.25}, {{1, 0}, 0}}};
  const auto ordered = OrderByJumps({arc}, {});
  ASSERT_EQ(ordered.front().places.front().at_mm, Vec2(1, 0));
  std::vector<Vec2> is = PlacesOf(ordered.front(), 0.01), was = PlacesOf(arc, 0.01);
  std::ranges::reverse(is);
  ASSERT_EQ(is.size(), was.size());
  for (std::size_t i = 0; i < is.size(); ++i) EXPECT_LT((is[i] - was[i]).norm(), 1e-9);
}

}  // namespace
}  // namespace intaglio::mark
