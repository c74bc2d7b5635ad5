#include "engrave/calibrate/test_pattern.h"

#include <gmock/gmock.h>

#include <map>

#include "engrave/calibrate/approach.h"
#include "engrave/sort/order.h"

namespace intaglio::calibrate {
namespace {

motion::PlanOptions Plan() {
  motion::PlanOptions plan;
  plan.limits.travel_mm = {Vec3::Constant(-2), Vec3::Constant(172)};
  plan.limits.max_speed_mm_s = Vec3::Constant(80);
  plan.limits.max_acceleration_mm_s2 = Vec3::Constant(7000);
  plan.rate_hz = 50;
  plan.continuous = true;
  return plan;
}

// The order of a job knows the cloud alone: its heights and rows bring the sequence back.
TEST(TestPattern, TheOrderOfTheJobMakesTheRowsInSequence) {
  const auto pattern = MakeTestPattern({});
  ASSERT_TRUE(pattern);
  sort::OrderOptions options;
  options.method = sort::Method::kBoustrophedon;
  options.boustrophedon = {pattern->layer_mm, pattern->row_width_mm};
  options.cone = 0.13;
  PointList shuffled = pattern->marks_mm;
  std::reverse(shuffled.begin(), shuffled.end());
  const auto order = sort::MakeOrder(shuffled, options);
  ASSERT_TRUE(order);
  for (std::size_t i = 0; i < order->size(); ++i) {
    EXPECT_EQ(shuffled[(*order)[i]], pattern->marks_mm[i]) << i;
  }
}

TEST(TestPattern, MarksAreApartAndWithinTheMargins) {
  TestPatternOptions options;
  options.block_mm = Vec3(40, 60, 20);
  const auto pattern = MakeTestPattern(options);
  ASSERT_TRUE(pattern);
  EXPECT_EQ(pattern->marks_mm.size(), 9u * 8 * 6);
  double nearest_mm = 1e9;
  for (std::size_t i = 0; i < pattern->marks_mm.size(); ++i) {
    const Vec3& p = pattern->marks_mm[i];
    EXPECT_TRUE((p.array() >= 3 - 1e-9).all()) << p.transpose();
    EXPECT_TRUE(((options.block_mm - p).array() >= 3 - 1e-9).all()) << p.transpose();
    for (std::size_t k = 0; k < i; ++k) {
      nearest_mm = std::min(nearest_mm, (p - pattern->marks_mm[k]).head<2>().norm());
    }
  }
  EXPECT_NEAR(nearest_mm, 0.3, 1e-9);
}

// What the fit needs: for each axis both directions, each slowly and fast, at all places.
TEST(TestPattern, EveryKindOfApproachOccurs) {
  const auto pattern = MakeTestPattern({});
  ASSERT_TRUE(pattern);
  const auto approaches = ApproachesOf(Plan(), pattern->marks_mm);
  ASSERT_EQ(approaches.size(), pattern->marks_mm.size());
  for (int axis = 0; axis < 2; ++axis) {
    std::map<std::pair<double, bool>, int> counts;
    for (const Approach& approach : approaches) {
      const double speed = std::abs(approach.speed_mm_s[axis]);
      if (approach.direction[axis] == 0 || speed < 8) continue;
      EXPECT_EQ(approach.direction[axis] > 0, approach.speed_mm_s[axis] > 0);
      ++counts[{approach.direction[axis], speed > 40}];
    }
    ASSERT_EQ(counts.size(), 4u);
    for (const auto& [kind, count] : counts) EXPECT_GE(count, 27) << kind.first;
  }
}

TEST(TestPattern, ABlockThatIsTooSmallIsRefusedWithTheSmallest) {
  TestPatternOptions options;
  options.block_mm = Vec3(20, 50, 50);
  const auto pattern = MakeTestPattern(options);
  ASSERT_FALSE(pattern);
  EXPECT_EQ(pattern.error().message,
            "block 20 x 50 x 50 mm is too small for the test pattern; take one of 24 x "
            "31.2 x 7.44 mm or more");
}

// By hand: up to 5, back to 4.8, on to 6. 0.2 mm after the turn nothing is known.
TEST(Approach, ADirectionIsKnownSomeWayBehindATurn) {
  motion::PlanOptions plan = Plan();
  plan.continuous = false;
  const auto approaches =
      ApproachesOf(plan, {{0, 0, 0}, {5, 0, 0}, {4.8, 0, 0}, {4.6, 0, 0}, {6, 0, 0}});
  EXPECT_EQ(approaches[1].direction.x(), 1);
  EXPECT_EQ(approaches[2].direction.x(), 0);
  EXPECT_EQ(approaches[3].direction.x(), -1);
  EXPECT_EQ(approaches[4].direction.x(), 1);
  for (const Approach& approach : approaches) {
    EXPECT_EQ(approach.direction.y(), 0) << "never moved";
    EXPECT_NEAR(approach.speed_mm_s.norm(), 0, 1e-9) << "stops at every point";
  }
}

}  // namespace
}  // namespace intaglio::calibrate
