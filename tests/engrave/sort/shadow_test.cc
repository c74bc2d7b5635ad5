#include "engrave/sort/shadow.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "engrave/core/check.h"
#include "tests/engrave/sort/clouds.h"
#include "tests/engrave/sort/shadow_oracle.h"

namespace intaglio::sort {
namespace {

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
        if (noise_mm == 0) {
          EXPECT_EQ(expected, 0) << name << ": from the lowest up";
        }
      }
    }
  }
}

TEST(Shadow, CountsWhatWasMadeAfterwardsNot) {
  const PointList points_mm = {{0, 0, 0}, {0, 0, 5}, {0, 0, 2}};
  EXPECT_EQ(CountShadowViolations(points_mm, {1, 0}, 0.1), 1);
  EXPECT_EQ(CountShadowViolations(points_mm, {0, 1}, 0.1), 0);
  EXPECT_EQ(CountShadowViolations(points_mm, {1, 2, 0}, 0.1), 2);
}

TEST(Shadow, WrongArgumentsThrow) {
  EXPECT_THROW(CountShadowViolations({{0, 0, 0}}, -0.1), PreconditionError);
}

}  // namespace
}  // namespace intaglio::sort
