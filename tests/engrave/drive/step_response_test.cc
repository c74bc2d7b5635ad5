// Published closed forms of the response to a unit step from rest (Ogata, Modern Control
// Engineering, 5th ed., 2010, ch. 5-2 and 5-3, eq. (5-3), (5-12), (5-13), (5-14) and the
// overshoot exp(-pi d / sqrt(1 - d^2)) at the time pi / (w sqrt(1 - d^2))).

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engrave/drive/first_order.h"
#include "engrave/drive/second_order.h"

namespace intaglio::drive {
namespace {

constexpr Cubic kUnitStep = {1, 0, 0, 0};

double StepOfSecondOrder(double w, double d, double t_s) {
  if (d < 1) {
    const double root = std::sqrt(1 - d * d);
    return 1 -
           std::exp(-d * w * t_s) / root * std::sin(w * root * t_s + std::atan2(root, d));
  }
  if (d == 1) return 1 - std::exp(-w * t_s) * (1 + w * t_s);
  const double root = std::sqrt(d * d - 1);
  const double s1 = (d + root) * w, s2 = (d - root) * w;
  return 1 + w / (2 * root) * (std::exp(-s1 * t_s) / s1 - std::exp(-s2 * t_s) / s2);
}

TEST(StepResponse, OfTheFirstOrder) {
  const FirstOrder drive(0.0002);
  for (double t_s = 0; t_s < 0.002; t_s += 0.0000131) {
    EXPECT_NEAR(drive.Follow({}, kUnitStep, t_s).position_u, 1 - std::exp(-t_s / 0.0002),
                1e-14);
  }
}

TEST(StepResponse, OfTheSecondOrderWithEveryKindOfDamping) {
  for (const double frequency_hz : {1.0, 37.0, 120.0, 10000.0}) {
    const double w = 2 * std::numbers::pi * frequency_hz;
    for (const double d : {0.05, 0.3, 0.7, 0.999, 1.0, 1.001, 2.0, 5.0}) {
      const SecondOrder drive(frequency_hz, d);
      for (double angle = 0.001; angle < 60; angle *= 1.07) {
        EXPECT_NEAR(drive.Follow({}, kUnitStep, angle / w).position_u,
                    StepOfSecondOrder(w, d, angle / w), 1e-11)
            << frequency_hz << " Hz, " << d << ", " << angle << " rad";
      }
    }
  }
}

TEST(StepResponse, OvershootAndItsTime) {
  const double w = 2 * std::numbers::pi * 120;
  for (const double d : {0.1, 0.5, 0.7, 0.9}) {
    const SecondOrder drive(120, d);
    const double root = std::sqrt(1 - d * d);
    const AxisState peak = drive.Follow({}, kUnitStep, std::numbers::pi / (w * root));
    EXPECT_NEAR(peak.position_u, 1 + std::exp(-std::numbers::pi * d / root), 1e-12);
    EXPECT_NEAR(peak.velocity_u_s, 0, 1e-9);
  }
}

// Between just below and just above critical damping nothing jumps.
TEST(StepResponse, IsSmoothThroughCriticalDamping) {
  for (const double below : {1e-6, 1e-9, 1e-12}) {
    for (double t_s = 0.0001; t_s < 0.02; t_s *= 1.3) {
      const double critical = SecondOrder(120, 1).Follow({}, kUnitStep, t_s).position_u;
      for (const double d : {1 - below, 1 + below}) {
        EXPECT_NEAR(SecondOrder(120, d).Follow({}, kUnitStep, t_s).position_u, critical,
                    2 * below + 1e-11);
      }
    }
  }
}

}  // namespace
}  // namespace intaglio::drive
