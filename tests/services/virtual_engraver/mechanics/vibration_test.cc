#include "services/virtual_engraver/mechanics/vibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace intaglio::virtual_engraver {
namespace {

constexpr double kStepS = 1e-4;

/// The largest |beside| of x while it accelerates for `duration_s` and after.
double Largest(const VibrationOptions& options, double mm_s2, double duration_s,
               double after_s = 0) {
  Vibration vibration(options, Vec3::Zero());
  double largest = 0, x = 0, speed = 0;
  for (double t = 0; t < duration_s + after_s; t += kStepS) {
    const double a = t < duration_s ? mm_s2 : 0;
    x += kStepS * (speed + kStepS / 2 * a);
    speed += kStepS * a;
    vibration.Follow({x, 0, 0}, kStepS);
    largest = std::max(largest, std::abs(vibration.beside_mm().x()));
    EXPECT_EQ(vibration.beside_mm().y(), 0);
  }
  return largest;
}

TEST(Vibration, BelowTheLimitNothingShakes) {
  EXPECT_EQ(Largest({7500, 60, 0.1}, 7400, 0.05, 0.05), 0);
}

// A step of the excess e of a spring with damping d: e / w^2 and its overshoot on top.
TEST(Vibration, AboveItTheExcessSwingsAsAStep) {
  for (const double d : {0.05, 0.3}) {
    const double w = 2 * std::numbers::pi * 60, excess = 2500;
    const double over = std::exp(-std::numbers::pi * d / std::sqrt(1 - d * d));
    // The difference of the places reaches the acceleration in a step of 0.04 rad.
    EXPECT_NEAR(Largest({7500, 60, d}, 10000, 0.05), excess / (w * w) * (1 + over),
                0.02 * excess / (w * w));
  }
}

TEST(Vibration, ItDecaysAfterwards) {
  const VibrationOptions options{7500, 60, 0.1};
  Vibration vibration(options, Vec3::Zero());
  double x = 0, speed = 0;
  for (int i = 0; i < 10000; ++i) {
    const double a = i < 100 ? -12000 : 0;
    x += kStepS * (speed + kStepS / 2 * a);
    speed += kStepS * a;
    vibration.Follow({0, 0, x}, kStepS);
  }
  EXPECT_LT(vibration.beside_mm().norm(), 1e-9);
}

// Steps of different lengths measure the same acceleration.
TEST(Vibration, DoesNotDependOnTheSteps) {
  Vibration vibration({7500, 60, 0.1}, Vec3::Zero());
  double t = 0;
  for (int i = 0; i < 400; ++i) {
    const double step_s = i % 3 == 0 ? 3e-5 : 1e-4;
    t += step_s;
    vibration.Follow({3700 * t * t, 0, 0}, step_s);
    EXPECT_LT(vibration.beside_mm().norm(), 1e-12) << i;
  }
}

}  // namespace
}  // namespace intaglio::virtual_engraver
