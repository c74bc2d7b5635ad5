// The sorters on a cloud that is spaced irregularly, like that of a figurine.

#include <gtest/gtest.h>

#include <string>

#include "engrave/sort/order.h"
#include "engrave/sort/planned_ticks.h"
#include "engrave/sort/shadow.h"
#include "engrave/sort/travel.h"
#include "tests/engrave/motion/paths.h"
#include "tests/engrave/sort/shadow_oracle.h"

namespace intaglio::sort {
namespace {

class Scatter : public ::testing::Test {
 protected:
  void SetUp() override {
    points_mm_ = FittedPoints("scatter");
    ASSERT_EQ(points_mm_.size(), 16179u);
  }

  PointList points_mm_;
};

TEST_F(Scatter, KdzFiresThroughNothing) {
  for (const double tangent : {0.13, 0.3, 0.6}) {
    const Order order = MakeOrder(points_mm_, {}).value();
    EXPECT_EQ(CountShadowViolations(points_mm_, order, tangent), 0) << tangent;
  }
}

TEST_F(Scatter, KdzMovesLessThanTheFileAndThanLayers) {
  Order as_filed(points_mm_.size());
  for (std::uint32_t i = 0; i < as_filed.size(); ++i) as_filed[i] = i;
  OrderOptions layers;
  layers.method = Method::kLayers;
  layers.layers.layer_thickness_mm = 0.5;
  const double kdz_mm =
      MeasureTravel(points_mm_, MakeOrder(points_mm_, {}).value()).largest_axis_mm;
  const double layers_mm =
      MeasureTravel(points_mm_, MakeOrder(points_mm_, layers).value()).largest_axis_mm;
  RecordProperty("kdz_mm_per_point", std::to_string(kdz_mm / as_filed.size()));
  RecordProperty("layers_mm_per_point", std::to_string(layers_mm / as_filed.size()));
  EXPECT_LT(kdz_mm, layers_mm);
  EXPECT_LT(kdz_mm, MeasureTravel(points_mm_, as_filed).largest_axis_mm);
}

// Limits and beam of the machine it was measured for: with hardly a pulse left out.
TEST_F(Scatter, AnnealingUsesNearlyEveryPulse) {
  OrderOptions options;
  options.method = Method::kAnneal;
  options.anneal.tries_per_point = 40;
  options.cone = 0.1328;
  options.rate_hz = 100;
  options.limits.max_speed_mm_s = Vec3::Constant(80);
  options.limits.max_acceleration_mm_s2 = Vec3::Constant(7000);
  const Order order = MakeOrder(points_mm_, options).value();
  EXPECT_EQ(CountShadowViolations(points_mm_, order, options.cone), 0);
  const auto ticks = PlannedTicks(points_mm_, order, options.limits, options.rate_hz);
  const double utilisation =
      static_cast<double>(order.size() - 1) / static_cast<double>(ticks);
  RecordProperty("utilisation", std::to_string(utilisation));
  EXPECT_GE(utilisation, 0.9975);
}

// At 200 Hz there is much to gain: for one piece less than for many of them, and never
// more time than that.
TEST_F(Scatter, AnnealingGoesOnWhileItIsWorthIt) {
  OrderOptions options;
  options.method = Method::kAnneal;
  options.cone = 0.1328;
  options.rate_hz = 200;
  options.limits.max_speed_mm_s = Vec3::Constant(80);
  options.limits.max_acceleration_mm_s2 = Vec3::Constant(10000);
  struct Row {
    double pieces, utilisation;
  };
  for (const auto& [pieces, expected] : {Row{1, 0.977}, Row{10, 0.984}}) {
    options.anneal.pieces = pieces;
    const Order order = MakeOrder(points_mm_, options).value();
    EXPECT_EQ(CountShadowViolations(points_mm_, order, options.cone), 0);
    const auto ticks = PlannedTicks(points_mm_, order, options.limits, options.rate_hz);
    const double utilisation =
        static_cast<double>(order.size() - 1) / static_cast<double>(ticks);
    RecordProperty(std::to_string(pieces), std::to_string(utilisation));
    EXPECT_GE(utilisation, expected) << pieces;
  }
}

// With points at equal distances the axes need many steps to get faster: an order that is
// only changed to what they can follow already stays at 0.51 points a tick.
TEST(SphereAtAHighRate, IsAnnealedFirstToWhatTheAxesCannotFollowYet) {
  const PointList points_mm = SphereContours(8, 0.15, 0.15);
  OrderOptions options;
  options.method = Method::kAnneal;
  options.rate_hz = 1000;
  options.limits.max_speed_mm_s = Vec3::Constant(1000);
  options.limits.max_acceleration_mm_s2 = Vec3::Constant(20000);
  const Order order = MakeOrder(points_mm, options).value();
  EXPECT_EQ(CountShadowViolations(points_mm, order, options.cone), 0);
  const auto ticks = PlannedTicks(points_mm, order, options.limits, options.rate_hz);
  EXPECT_LT(ticks, points_mm.size() / 0.68);
}

// The jerk is no limit of an order, so it needs the reserve of gentle steps.
TEST_F(Scatter, AnnealingLeavesAReserveForWhatElseTheMotionKeeps) {
  OrderOptions options;
  options.method = Method::kAnneal;
  options.anneal.tries_per_point = 30;
  options.cone = 0.1328;
  motion::Limits of_motion = options.limits;
  of_motion.max_jerk_mm_s3 = Vec3::Constant(2e6);
  const auto ticks = [&](bool keeps_more) {
    options.keeps_more = keeps_more;
    const Order order = MakeOrder(points_mm_, options).value();
    return PlannedTicks(points_mm_, order, of_motion, options.rate_hz);
  };
  EXPECT_LT(ticks(true), 0.98 * ticks(false));
}

}  // namespace
}  // namespace intaglio::sort
