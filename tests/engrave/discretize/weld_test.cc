#include "engrave/discretize/weld.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include "tests/engrave/discretize/oracles.h"

namespace intaglio::discretize {
namespace {

PointCloud RandomCloud(unsigned seed, int count, double size_mm, bool on_grid) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-size_mm, size_mm);
  PointCloud cloud;
  for (int i = 0; i < count; ++i) {
    Vec3 p(coordinate(random), coordinate(random), coordinate(random));
    if (on_grid) p = (p * 4).array().round().matrix() / 4;
    cloud.Add(p, random() % 3);
  }
  return cloud;
}

TEST(Weld, KeepsTheSpacingAndLeavesNoGap) {
  for (unsigned seed = 0; seed < 12; ++seed) {
    const double spacing = 0.25 + 0.05 * seed;
    const PointCloud cloud = RandomCloud(seed, 1500, 2, seed % 2 == 1);
    const PointCloud kept = WeldToSpacing(cloud, spacing);
    const double square = spacing * spacing;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        ASSERT_GE((kept.points_mm[i] - kept.points_mm[j]).squaredNorm(), square);
      }
    }
    for (const Vec3& p : cloud.points_mm) {
      const bool covered = std::any_of(
          kept.points_mm.begin(), kept.points_mm.end(),
          [&](const Vec3& q) { return p == q || (p - q).squaredNorm() < square; });
      ASSERT_TRUE(covered);
    }
  }
}

TEST(Weld, DependsOnThePointsNotOnTheirOrder) {
  const PointCloud cloud = RandomCloud(5, 3000, 2, false);
  const PointCloud kept = WeldToSpacing(cloud, 0.2);
  std::vector<std::size_t> order(cloud.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), std::mt19937(9));
  PointCloud shuffled;
  for (const std::size_t i : order) shuffled.Add(cloud.points_mm[i], cloud.source[i]);
  const PointCloud again = WeldToSpacing(shuffled, 0.2);
  EXPECT_EQ(kept.points_mm, again.points_mm);
  EXPECT_EQ(kept.source, again.source);
}

TEST(Weld, CoincidentPointsBecomeOne) {
  PointCloud cloud;
  for (int i = 0; i < 10; ++i)
    cloud.Add(Vec3(1, 2, 3), static_cast<std::uint32_t>(9 - i));
  const PointCloud kept = WeldToSpacing(cloud, 0.1);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept.source[0], 0u) << "the first model's";
}

TEST(Weld, ExactlyTheSpacingApartIsFarEnough) {
  PointCloud cloud;
  for (int i = 0; i < 5; ++i) cloud.Add(Vec3(0.25 * i, 0, 0), 0);
  EXPECT_EQ(WeldToSpacing(cloud, 0.25).size(), 5u);
}

TEST(Weld, TinySpacingInALargeBlockTakesLittle) {
  PointCloud cloud;
  cloud.Add(Vec3(0, 0, 0), 0);
  cloud.Add(Vec3(1000, 1000, 1000), 0);
  EXPECT_EQ(WeldToSpacing(cloud, 1e-6).size(), 2u);
  EXPECT_EQ(WeldToSpacing({}, 1).size(), 0u);
}

// Multiples of the spacing, off by the last digits: whether two are near enough is a
// matter of rounding, and so is the column of the grid they fall into.
TEST(Weld, NeighboursAtTheSpacingButForRoundingAreAsByBruteForce) {
  std::mt19937 random(11);
  for (const double spacing : {0.1, 0.13, 1.0 / 3}) {
    PointCloud cloud;
    for (int i = 0; i < 600; ++i) {
      Vec3 p;
      for (int axis = 0; axis < 3; ++axis) {
        p[axis] = spacing * static_cast<double>(random() % (axis == 0 ? 40 : 4));
        for (unsigned k = random() % 4; k > 0; --k) p[axis] = std::nextafter(p[axis], -1);
        for (unsigned k = random() % 4; k > 0; --k) p[axis] = std::nextafter(p[axis], 99);
      }
      cloud.Add(p, 0);
    }
    // The rule of weld.h, word for word.
    PointList sorted = cloud.points_mm;
    std::sort(sorted.begin(), sorted.end(), [](const Vec3& a, const Vec3& b) {
      return std::tuple(a.z(), a.y(), a.x()) < std::tuple(b.z(), b.y(), b.x());
    });
    PointList expected;
    for (const Vec3& p : sorted) {
      const bool taken = std::any_of(
          expected.begin(), expected.end(),
          [&](const Vec3& q) { return (p - q).squaredNorm() < spacing * spacing; });
      if (!taken) expected.push_back(p);
    }
    EXPECT_EQ(WeldToSpacing(cloud, spacing).points_mm, expected);
  }
}

TEST(Weld, ZeroAndMinusZeroAreTheSamePoint) {
  PointCloud one, other;
  one.Add(Vec3(0.0, -0.0, 0.0), 0);
  one.Add(Vec3(-0.0, 0.0, -0.0), 0);
  other.Add(one.points_mm[1], 0);
  other.Add(one.points_mm[0], 0);
  for (const PointCloud& cloud : {one, other}) {
    const PointCloud kept = WeldToSpacing(cloud, 0.1);
    ASSERT_EQ(kept.size(), 1u);
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_FALSE(std::signbit(kept.points_mm[0][axis]));
  }
}

// A point far away makes the columns wider than the spacing and the buckets few.
TEST(Weld, AFarPointDoesNotChangeTheRest) {
  PointCloud cloud = RandomCloud(3, 2000, 0.01, false);
  const PointCloud near = WeldToSpacing(cloud, 0.001);
  cloud.Add(Vec3(900, 900, 900), 0);
  PointCloud with_far = WeldToSpacing(cloud, 0.001);
  ASSERT_EQ(with_far.size(), near.size() + 1);
  with_far.points_mm.pop_back();
  EXPECT_EQ(with_far.points_mm, near.points_mm);
}

TEST(Weld, LargeCloudsKeepTheSpacingToo) {
  const double spacing = 0.05;
  const PointCloud kept = WeldToSpacing(RandomCloud(8, 300'000, 1, false), spacing);
  ASSERT_GT(kept.size(), 10'000u);
  // nanoflann adds the squares in another order: the last digit may differ.
  EXPECT_GE(LeastDistance(kept.points_mm), spacing * (1 - 1e-15));
}

}  // namespace
}  // namespace intaglio::discretize
