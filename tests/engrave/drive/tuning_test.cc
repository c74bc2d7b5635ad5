#include "engrave/drive/tuning.h"

#include <gtest/gtest.h>

#include <array>

#include "engrave/core/check.h"
#include "engrave/drive/sampled_axis.h"
#include "tests/engrave/drive/tirnovean.h"

namespace intaglio::drive {
namespace {

TunedAxis Axis(const char* name, double inertia_kg_m2) {
  return {name, CloseVelocityLoop(kSourceMotor, kSourceAmplifier, inertia_kg_m2),
          0.01, 8.557 / 0.18,
          132,  20,
          0.5};
}

constexpr TuningDemand kDemand = {Regime::kCircle, 2.0 / 60, 0.0004};

double Loaded() {
  return InertiaOf(kSourceAxis, kSourceMotor, CylinderRule::kTirnovean2016).total_kg_m2;
}

// drives.md: zeta .7 gives 166 1/s for the printed time of the rotor, 83 loaded.
TEST(Tuning, TheGainIsThatOfTheDamping) {
  TunedAxis rotor = Axis("x", kSourceMotor.inertia_kg_m2);
  rotor.velocity = SourceVelocity();
  const auto alone = Tune(std::array{rotor}, kDemand);
  EXPECT_NEAR(alone[0].servo.position_gain_per_s, 166, 0.5);
  EXPECT_NEAR(DampingRatio(alone[0].servo), 0.7, 1e-9);
  const auto loaded = Tune(std::array{Axis("x", Loaded())}, kDemand);
  EXPECT_NEAR(loaded[0].servo.position_gain_per_s, 83, 0.5);
}

TEST(Tuning, AllAxesHaveTheGainOfTheSlowest) {
  const std::array axes = {Axis("x", kSourceMotor.inertia_kg_m2), Axis("y", Loaded())};
  const auto tunings = Tune(axes, kDemand);
  ASSERT_EQ(tunings.size(), 2u);
  EXPECT_NEAR(tunings[0].servo.position_gain_per_s, tunings[1].servo.position_gain_per_s,
              1e-9);
  EXPECT_NEAR(DampingRatio(tunings[1].servo), 0.7, 1e-9);
  EXPECT_GT(DampingRatio(tunings[0].servo), 0.7);
  EXPECT_NE(tunings[0].advice[0].reason.find("ellipse"), std::string::npos);
  EXPECT_GT(tunings[0].advice[0].limit, tunings[0].advice[0].value);
}

TEST(Tuning, FeedForwardLeavesNoLagAndLoadLeavesItsError) {
  const auto tunings = Tune(std::array{Axis("x", Loaded())}, kDemand);
  EXPECT_EQ(tunings[0].following_lag_s, 0);
  EXPECT_NEAR(
      tunings[0].static_error_m,
      0.5 * tunings[0].servo.velocity_time_s / tunings[0].servo.position_gain_per_s,
      1e-15);
}

// The source: the derivative of a held reference with Kd = 1 asks for 121 A.
TEST(Tuning, TheDerivativeIsLimitedByTheCurrentOfHeldReferences) {
  const auto tunings = Tune(std::array{Axis("x", Loaded())}, kDemand);
  const Advice& derivative = tunings[0].advice[1];
  const double volt_s_per_m = SourceLoop(1, 1, PanelUnit::kEncoderPulse).volt_s_per_m;
  const double ampere = volt_s_per_m * kDemand.speed_m_s * 8.557 / 0.18;
  EXPECT_NEAR(ampere, 121, 0.5);
  EXPECT_NEAR(derivative.limit, volt_s_per_m * (132 - 20) / ampere, 1e-9);
  EXPECT_LT(derivative.limit, volt_s_per_m);
}

TEST(Tuning, ASlowControllerLowersTheGain) {
  TuningDemand slow = kDemand;
  slow.period_s = 0.01;
  const auto tunings = Tune(std::array{Axis("x", Loaded())}, slow);
  EXPECT_GE(tunings[0].largest_stable_period_s, 0.1);
  EXPECT_LT(tunings[0].servo.position_gain_per_s, 50);
  EXPECT_NE(tunings[0].advice[0].reason.find("samples"), std::string::npos);
}

TEST(Tuning, WhatIsNoDemandIsRefused) {
  TuningDemand wrong = kDemand;
  wrong.speed_m_s = 0;
  EXPECT_THROW(Tune(std::array{Axis("x", Loaded())}, wrong), PreconditionError);
  EXPECT_THROW(Tune({}, kDemand), PreconditionError);
}

}  // namespace
}  // namespace intaglio::drive
