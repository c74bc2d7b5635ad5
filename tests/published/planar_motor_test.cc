#include "tests/published/planar_motor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "engrave/core/check.h"

namespace intaglio::drive {
namespace {

constexpr double kTooth = 0.64;

TEST(PlanarMotor, WithoutThirdHarmonicTheCurrentsTurnOnACircle) {
  for (double x = -1; x < 1; x += 0.013) {
    const PhaseCurrents open = OpenLoopCurrents(2, x, kTooth, 0);
    EXPECT_NEAR(std::hypot(open.first_a, open.second_a), 2, 1e-12);
    const PhaseCurrents closed = ClosedLoopCurrents(2, x, kTooth, 0, 0);
    EXPECT_NEAR(closed.first_a, open.first_a, 1e-12);
    EXPECT_NEAR(closed.second_a, open.second_a, 1e-12);
  }
}

// The normalization of (103) and (107): the largest phase current is the amplitude.
TEST(PlanarMotor, TheLargestPhaseCurrentIsTheAmplitude) {
  for (const double k3 : {0.0, 0.05, 0.1}) {
    double open_a = 0, closed_a = 0;
    for (double x = 0; x < kTooth; x += kTooth / 4000) {
      const PhaseCurrents open = OpenLoopCurrents(3, x, kTooth, k3);
      const PhaseCurrents closed = ClosedLoopCurrents(3, x, kTooth, k3, 0);
      open_a = std::max({open_a, std::abs(open.first_a), std::abs(open.second_a)});
      closed_a =
          std::max({closed_a, std::abs(closed.first_a), std::abs(closed.second_a)});
    }
    EXPECT_NEAR(open_a, 3, 1e-5) << k3;
    EXPECT_NEAR(closed_a, 3, 3e-2) << k3;
  }
}

// (106), corrected: the sum of the increments is the PID of the sum.
TEST(PlanarMotor, TheIncrementalControllerIsAPid) {
  IncrementalPid pid(3, 0.25, 7);
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal(0, 1);
  double sum = 0, last = 0;
  for (int i = 0; i < 200; ++i) {
    const double e = normal(random);
    sum += e;
    EXPECT_NEAR(pid.Next(e), 3 * e + 0.25 * sum + 7 * (e - last), 1e-9);
    last = e;
  }
}

// 0.64 mm / 4096: 0.156 um; 0.65 mm: 0.159 um.
TEST(PlanarMotor, ASensorWithoutErrorsReadsToHalfItsDivision) {
  SineCosineSensor sensor;
  EXPECT_NEAR(sensor.resolution_mm(), 0.15625e-3, 1e-12);
  for (double x = -3; x < 3; x += 0.00137)
    EXPECT_LE(std::abs(Read(sensor, x) - x), sensor.resolution_mm() / 2 + 1e-12);
}

TEST(PlanarMotor, WrongSignalsAreWrongByTheirBound) {
  for (const SineCosineSensor& sensor :
       {SineCosineSensor{0.64, 1u << 20, 0.01, 0, 1, 0},
        SineCosineSensor{0.64, 1u << 20, 0, 0, 1.02, 0},
        SineCosineSensor{0.64, 1u << 20, 0, 0, 1, 0.015},
        SineCosineSensor{0.65, 1u << 20, 0.004, -0.003, 0.99, 0.01}}) {
    double min = 1, max = -1;
    for (double x = 0; x < 2; x += 0.0007) {
      const double error = Read(sensor, x) - x;
      min = std::min(min, error), max = std::max(max, error);
    }
    // Half the span: a constant is the place of the zero. Second order: a per cent.
    EXPECT_LE((max - min) / 2, 1.02 * InterpolationError(sensor) + 1e-6);
    EXPECT_GE((max - min) / 2, 0.5 * InterpolationError(sensor));
  }
}

TEST(PlanarMotor, WhatIsNoSensorIsRefused) {
  EXPECT_THROW(Read({0, 4096}, 1), PreconditionError);
  EXPECT_THROW(OpenLoopCurrents(1, 0, 0.64, 0.4), PreconditionError);
}

}  // namespace
}  // namespace intaglio::drive
