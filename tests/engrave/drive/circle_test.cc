#include "engrave/drive/circle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"
#include "engrave/drive/motor.h"

namespace intaglio::drive {
namespace {

// Tirnovean 2016, ch. 5: R 30 mm, F 2000 mm/min, Ts .4 ms.
CircularInterpolator SourceCircle(RotationRule rule) {
  return {30, 2000.0 / 60, 4e-4, rule};
}

Vec2 AfterATurn(CircularInterpolator circle) {
  for (int i = 0; i < circle.steps_per_turn(); ++i) circle.Next();
  return circle.at();
}

/// How far a chord between two setpoints is inside of the circle at most.
double SagOf(const CircularInterpolator& circle, double radius) {
  const double half = std::sin(std::numbers::pi / (2 * circle.steps_per_turn()));
  return radius * 2 * half * half;
}

TEST(Circle, TheExactRotationComesBack) {
  const CircularInterpolator circle = SourceCircle(RotationRule::kExact);
  EXPECT_EQ(circle.steps_per_turn(), 14137);
  EXPECT_LT((AfterATurn(circle) - Vec2(30, 0)).norm(), 1e-9);
  EXPECT_NEAR(SagOf(circle, 30), 0.74e-6, 5e-9);
}

TEST(Circle, TustinKeepsTheRadiusAndIsALittleSlow) {
  const Vec2 end = AfterATurn(SourceCircle(RotationRule::kTustin));
  EXPECT_NEAR(end.norm(), 30, 1e-9);
  EXPECT_NEAR(1000 * 30 * std::atan2(end.y(), end.x()), -0.0031, 5e-5);
}

TEST(Circle, EulerGrows) {
  const Vec2 end = AfterATurn(SourceCircle(RotationRule::kEuler));
  EXPECT_NEAR(1000 * (end.norm() - 30), 41.92, 5e-3);
}

TEST(Circle, TheChordsAreInsideByTheirSag) {
  CircularInterpolator circle(10, 100, 0.002, RotationRule::kExact);
  double deepest = 0;
  Vec2 from = circle.at();
  for (int i = 0; i < circle.steps_per_turn(); ++i) {
    const Vec2 to = circle.Next();
    deepest = std::max(deepest, 10 - (0.5 * (from + to)).norm());
    from = to;
  }
  EXPECT_NEAR(deepest, SagOf(circle, 10), 1e-9);
}

TEST(Circle, WhatIsNoCircleIsRefused) {
  EXPECT_THROW(CircularInterpolator(0, 1, 1, RotationRule::kExact), PreconditionError);
  EXPECT_THROW(CircularInterpolator(1, 4, 1, RotationRule::kExact), PreconditionError);
}

// Unequal gains make an ellipse: its half-axes along the diagonals differ from the radius
// by (K1 - K2) / (2 K1 K2) times the speed, here from the phases at low speed.
TEST(Circle, UnequalGainsMakeAnEllipse) {
  const double k1 = 327.5, k2 = 1.2 * k1, speed = 2000.0 / 60, radius = 22;
  const double omega = speed / radius;
  const double phase1 = std::atan(omega / k1), phase2 = std::atan(omega / k2);
  double min = 1e9, max = -1e9;
  for (double t = 0; t < 2 * std::numbers::pi; t += 0.001) {
    const double off =
        std::hypot(std::cos(t - phase1) * radius, std::sin(t - phase2) * radius) - radius;
    min = std::min(min, off), max = std::max(max, off);
  }
  const double amplitude = (k2 - k1) / (2 * k1 * k2) * speed;
  EXPECT_NEAR((max - min) / 2, amplitude, 0.001 * amplitude);
  EXPECT_NEAR(1000 * amplitude, 8.5, 0.1);
  EXPECT_NEAR(LagSeconds({k1, 0.003, 0, 0}) - LagSeconds({k2, 0.003, 0, 0}),
              2 * amplitude / speed, 1e-15);
}

}  // namespace
}  // namespace intaglio::drive
