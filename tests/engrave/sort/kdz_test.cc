#include "engrave/sort/kdz.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "engrave/sort/shadow.h"
#include "tests/engrave/sort/clouds.h"
#include "tests/engrave/sort/shadow_oracle.h"

namespace intaglio::sort {
namespace {

Order MakeKdz(const PointList& points_mm, double up_ratio) {
  OrderOptions options;
  options.kdz.up_ratio = up_ratio;
  return MakeOrder(points_mm, options).value();
}

/// (z, y, x, index) of a before b.
bool Lower(const PointList& points_mm, std::uint32_t a, std::uint32_t b) {
  const Vec3& p = points_mm[a];
  const Vec3& q = points_mm[b];
  return std::tuple(p.z(), p.y(), p.x(), a) < std::tuple(q.z(), q.y(), q.x(), b);
}

/// The definition: every remaining point compared at every step. The weight of the
/// present height is the same for all of them and left out, as it would only add a
/// rounding.
Order BruteForceKdz(const PointList& points_mm, double up_ratio) {
  std::vector<std::uint32_t> left(points_mm.size());
  std::iota(left.begin(), left.end(), 0U);
  Order order;
  while (!left.empty()) {
    auto best = left.begin();
    double best_cost = std::numeric_limits<double>::infinity();
    for (auto candidate = left.begin(); candidate != left.end(); ++candidate) {
      const Vec3& p = points_mm[*candidate];
      double cost = 0;
      if (!order.empty()) {
        const Vec3& now = points_mm[order.back()];
        cost = std::max(std::abs(p.x() - now.x()), std::abs(p.y() - now.y())) +
               up_ratio * p.z();
      }
      if (cost < best_cost ||
          (cost == best_cost && Lower(points_mm, *candidate, *best))) {
        best_cost = cost;
        best = candidate;
      }
    }
    order.push_back(*best);
    left.erase(best);
  }
  return order;
}

TEST(Kdz, IsTheGreedyOfItsDefinition) {
  for (const auto& [name, points_mm] : Clouds(1200)) {
    for (const double up_ratio : {0.0, 0.13, 0.6, 1.0, 7.0}) {
      EXPECT_EQ(MakeKdz(points_mm, up_ratio), BruteForceKdz(points_mm, up_ratio))
          << name << ", K = " << up_ratio;
    }
  }
}

TEST(Kdz, IsExactForEverySmallCount) {
  // Around the sizes of a leaf (8), of a node (64) and of a second level (512).
  for (const std::size_t count : {1, 2, 7, 8, 9, 63, 64, 65, 511, 512, 513}) {
    const PointList points_mm = RandomBox(count, {3, 4, 5}, 11);
    EXPECT_EQ(MakeKdz(points_mm, 0.6), BruteForceKdz(points_mm, 0.6)) << count;
  }
  EXPECT_TRUE(MakeKdz({}, 0.6).empty());
}

TEST(Kdz, IsExactWhenAllPointsAreOne) {
  const PointList points_mm(100, Vec3(1, 2, 3));
  EXPECT_EQ(MakeKdz(points_mm, 0.6), BruteForceKdz(points_mm, 0.6));
}

TEST(Kdz, NeverFiresThroughAnEarlierCrack) {
  for (const auto& [name, points_mm] : Clouds(1500)) {
    for (const double tangent : {0.05, 0.13, 0.4, 1.0}) {
      for (const double factor : {1.0, 1.5, 8.0}) {
        const Order order = MakeKdz(points_mm, factor * tangent);
        EXPECT_EQ(CountShadowViolations(points_mm, order, tangent), 0)
            << name << ", tangent " << tangent << ", K = " << factor << " tangent";
      }
    }
  }
}

TEST(Kdz, NeverFiresThroughAnEarlierCrackOfALargeCloud) {
  const PointList points_mm = DentedSphere(60000, 21);
  EXPECT_EQ(CountShadowViolations(points_mm, MakeKdz(points_mm, 0.6), 0.6), 0);
}

TEST(Kdz, BelowTheTangentItDoes) {
  // The theorem's condition is needed: so the checks above are able to fail.
  const PointList points_mm = RandomBox(2000, {10, 10, 10}, 12);
  EXPECT_GT(CountShadowViolations(points_mm, MakeKdz(points_mm, 0.2), 0.4), 0);
}

TEST(Kdz, StartsAtTheLowestPoint) {
  const PointList points_mm = {{5, 5, 1}, {3, 2, 0}, {1, 2, 0}, {0, 3, 0}, {1, 2, 0}};
  EXPECT_EQ(MakeKdz(points_mm, 0.6).front(), 2);
}

TEST(Kdz, DefaultRatioIsSafeAndNotBelowTheMinimumMoving) {
  EXPECT_EQ(DefaultUpRatio(0.13), 0.6);
  EXPECT_EQ(DefaultUpRatio(0.8), 0.8);
}

}  // namespace
}  // namespace intaglio::sort
