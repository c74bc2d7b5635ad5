#include "engrave/sort/shadow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "engrave/core/check.h"
#include "tests/engrave/sort/clouds.h"

namespace intaglio::sort {
namespace {

Order Shuffled(std::size_t count, std::uint32_t seed) {
  Order order(count);
  std::iota(order.begin(), order.end(), 0U);
  std::shuffle(order.begin(), order.end(), std::mt19937(seed));
  return order;
}

PointList InOrder(const PointList& points_mm, const Order& order) {
  PointList made_mm;
  for (const std::uint32_t i : order) made_mm.push_back(points_mm[i]);
  return made_mm;
}

TEST(Shadow, IsARoundConeUpwards) {
  const Vec3 p(10, 20, 30);
  const double t = 0.5;
  const auto violated = [&](const Vec3& earlier_offset) {
    return CountShadowViolations({p + earlier_offset, p}, t) == 1;
  };
  EXPECT_TRUE(violated({0, 0, 1}));
  EXPECT_TRUE(violated({0.49, 0, 1}));
  EXPECT_FALSE(violated({0.51, 0, 1}));
  // Inside the square about the circle, outside the circle: the beam is round.
  EXPECT_FALSE(violated({0.45, 0.45, 1}));
  EXPECT_TRUE(violated({0.35, 0.35, 1}));
  EXPECT_FALSE(violated({0.5, 0, 1}));  // on the surface
  EXPECT_FALSE(violated({0, 0, 0}));
  EXPECT_FALSE(violated({0, 0, -1}));
  EXPECT_EQ(CountShadowViolations({p, p + Vec3(0, 0, 1)}, t), 0) << "made afterwards";
  EXPECT_EQ(CountShadowViolations({}, t), 0);
}

TEST(Shadow, IndexAndBruteForceCountTheSame) {
  for (const auto& [name, points_mm] : Clouds(1500)) {
    // From wholly wrong to nearly right: by height, with some noise.
    for (const double noise_mm : {0.0, 0.3, 3.0, 1000.0}) {
      std::mt19937 random(9);
      std::uniform_real_distribution<double> noise(0, noise_mm);
      std::vector<std::pair<double, std::uint32_t>> keyed;
      for (std::uint32_t i = 0; i < points_mm.size(); ++i) {
        keyed.emplace_back(points_mm[i].z() + noise(random), i);
      }
      std::sort(keyed.begin(), keyed.end());
      Order order;
      for (const auto& [key, index] : keyed) order.push_back(index);
      const PointList made_mm = InOrder(points_mm, order);
      for (const double tangent : {0.0, 0.05, 0.3, 1.0, 20.0}) {
        const auto expected = CountShadowViolationsBruteForce(made_mm, tangent);
        EXPECT_EQ(CountShadowViolations(made_mm, tangent), expected) << name;
        EXPECT_EQ(CheckShadow(points_mm, order, tangent).violations, expected) << name;
        if (noise_mm == 0) {
          EXPECT_EQ(expected, 0) << name << ": from the lowest up";
        }
      }
    }
  }
}

TEST(Shadow, NamesTheFirstPairs) {
  const PointList points_mm = RandomBox(3000, {5, 5, 5}, 2);
  const Order order = Shuffled(points_mm.size(), 3);
  const double t = 0.4;
  const ShadowReport report = CheckShadow(points_mm, order, t);
  ASSERT_EQ(report.first.size(), ShadowReport::kMaxPairs);
  std::vector<ShadowPair> expected;
  for (std::size_t i = 0; i < order.size() && expected.size() < report.first.size();
       ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Vec3 d = points_mm[order[j]] - points_mm[order[i]];
      if (d.z() > 0 && std::hypot(d.x(), d.y()) < t * d.z()) {
        expected.push_back({order[i], order[j]});
        break;
      }
    }
  }
  EXPECT_EQ(report.first, expected);
}

TEST(Shadow, TakesAnOrderOfSomeOfThePoints) {
  const PointList points_mm = {{0, 0, 0}, {0, 0, 5}, {0, 0, 2}};
  EXPECT_EQ(CheckShadow(points_mm, {1, 0}, 0.1).violations, 1);
  EXPECT_EQ(CheckShadow(points_mm, {0, 1}, 0.1).violations, 0);
  EXPECT_EQ(CheckShadow(points_mm, {1, 2, 0}, 0.1).violations, 2);
}

TEST(Shadow, WrongArgumentsThrow) {
  EXPECT_THROW(CheckShadow({{0, 0, 0}}, {1}, 0.1), PreconditionError);
  EXPECT_THROW(CountShadowViolations({{0, 0, 0}}, -0.1), PreconditionError);
}

}  // namespace
}  // namespace intaglio::sort
