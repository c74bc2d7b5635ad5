// The regimes of Tirnovean 2016, ch. 5, with the assumptions that reproduce its figures:
// encoder pulses, a continuous controller, the rotor's time of 4 ms.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "engrave/drive/continuous_axis.h"
#include "engrave/drive/sampled_axis.h"
#include "tests/engrave/drive/tirnovean.h"

namespace intaglio::drive {
namespace {

constexpr double kRapidTorqueNm = 6.63389;  // (4.22)
constexpr double kCutTorqueNm = 1.5801;     // (4.23)

double Load(double torque_nm) {
  return LoadAcceleration(kSourceMotor, SourceVelocity(), kSourceAxis.lead_m, torque_nm);
}

/// Current, A, of the source's motor at a screw of 10 mm that accelerates and moves
/// against the torque of a rapid move.
double RapidCurrent(double acceleration_m_s2, double speed_m_s) {
  const double inertia_kg_m2 = 0.004 * (0.18 * 0.75e-4 + 0.6 * 0.2) / 0.18;
  const double metres_per_radian = 0.01 / (2 * std::numbers::pi);
  return (inertia_kg_m2 * acceleration_m_s2 / metres_per_radian + kRapidTorqueNm +
          kSourceMotor.friction_nm_s * speed_m_s / metres_per_radian) /
         kSourceMotor.torque_constant_nm_a;
}

struct Extremes {
  double min_m_s2 = 0, max_m_s2 = 0, end_error_m = 0, max_current_a = 0;
};

/// 200 mm at .4 m/s with 1.5 m/s^2.
Extremes Rapid(const ServoLoop& servo) {
  ContinuousAxis axis(servo, Load(kRapidTorqueNm), 0);
  Extremes extremes;
  for (const CommandPiece& piece : Trapezoid(0.2, 0.4, 1.5, 0.3)) {
    const int steps = static_cast<int>(std::ceil(piece.duration_s / 1e-5));
    const double h = piece.duration_s / steps;
    Cubic rest = piece.command;
    for (int i = 0; i < steps; ++i) {
      const double a = axis.Acceleration(rest.position_u, rest.velocity_u_s);
      extremes.min_m_s2 = std::min(extremes.min_m_s2, a);
      extremes.max_m_s2 = std::max(extremes.max_m_s2, a);
      extremes.max_current_a =
          std::max(extremes.max_current_a, std::abs(RapidCurrent(a, axis.speed())));
      axis.Follow(rest, h);
      rest = {rest.At(h), rest.VelocityAt(h), rest.acceleration_u_s2, 0};
    }
    extremes.end_error_m = rest.position_u - axis.position();
  }
  return extremes;
}

// Source: -3.9..6.2 m/s^2, .14314 um.
TEST(Regimes, TheRapidMoveRingsAsInTheSource) {
  const Extremes e = Rapid(SourceServo(20480, 0, PanelUnit::kEncoderPulse));
  EXPECT_NEAR(e.min_m_s2, -3.959, 3.959e-3);
  EXPECT_NEAR(e.max_m_s2, 6.449, 6.449e-3);
  EXPECT_NEAR(e.end_error_m, 0.148848e-6, 0.148848e-9);
  EXPECT_NEAR(e.max_current_a, 29, 0.5);
  // In closed form: the torque takes a0 at once, and the ring adds to the command's 1.5.
  const ServoLoop servo = SourceServo(20480, 0, PanelUnit::kEncoderPulse);
  const double d = DampingRatio(servo), a0 = -Load(kRapidTorqueNm);
  EXPECT_NEAR(e.min_m_s2, a0, 1e-9);
  const double ring = std::exp(-std::numbers::pi * d / std::sqrt(1 - d * d));
  EXPECT_NEAR(e.max_m_s2, 1.5 + (1.5 - a0) * ring, 0.01);
  EXPECT_NEAR(StaticError(servo, Load(kRapidTorqueNm)),
              kRapidTorqueNm * 0.18 / (0.6 * 8.557 * 20480 * 0.00030518 * 250000), 1e-18);
}

TEST(Regimes, TheDerivativeEndsTheRinging) {
  const Extremes e = Rapid(SourceServo(20480, 10, PanelUnit::kEncoderPulse));
  // The torque's own step is left, and the acceleration of the command.
  EXPECT_LT(e.max_m_s2, 2);
  EXPECT_NEAR(e.end_error_m, 0.148848e-6, 0.148848e-9);
  EXPECT_LT(e.max_current_a, 20);
}

/// The largest following error on the circle R 30 mm at 2000 mm/min with references held
/// for .4 ms, um. x starts from rest, y at full speed.
double CircleErrorUm(bool y_axis, double kp) {
  const double speed = 2.0 / 60, radius = 0.03, held_s = 4e-4;
  const double steps = std::round(2 * std::numbers::pi * radius / (speed * held_s));
  const ServoLoop servo = SourceServo(kp, 0, PanelUnit::kEncoderPulse);
  const auto reference = [&](int k) {
    const double phase = 2 * std::numbers::pi * k / steps;
    return y_axis ? radius * std::sin(phase) : -radius * std::cos(phase);
  };
  ContinuousAxis axis(servo, Load(kCutTorqueNm), reference(0));
  double largest_m = 0;
  for (int k = 0; k < static_cast<int>(0.27 * steps); ++k) {
    const double r = reference(k);
    for (int i = 0; i < 40; ++i) {
      largest_m = std::max(largest_m, r - axis.position());
      axis.Follow({r, 0, 0, 0}, held_s / 40);
    }
  }
  return 1e6 * largest_m;
}

// Source: 10, more than 27 and less than 22 um.
TEST(Regimes, TheCircleHasTheFollowingErrorsOfTheSource) {
  EXPECT_NEAR(CircleErrorUm(false, 2730.7), 9.99, 0.01);
  EXPECT_NEAR(CircleErrorUm(true, 2730.7), 25.43, 0.025);
  EXPECT_NEAR(CircleErrorUm(true, 4096.05), 21.81, 0.022);
}

SampledAxis Sampled(double kp, PanelUnit unit) {
  SampledAxis axis;
  axis.speed_per_volt = SourceVelocity().gain_rad_v_s * 0.01 / (2 * std::numbers::pi);
  axis.velocity_time_s = SourceVelocity().time_s;
  axis.loop = SourceLoop(kp, 0, unit);
  axis.period_s = 1e-5;
  return axis;
}

TEST(Regimes, TheSampledLoopIsStableForThePeriodsOfTheReference) {
  EXPECT_NEAR(LargestStablePeriod(Sampled(20480, PanelUnit::kEncoderPulse)), 24.5e-6,
              5e-8);
  EXPECT_NEAR(LargestStablePeriod(Sampled(2730.7, PanelUnit::kEncoderPulse)), 185e-6,
              5e-7);
  EXPECT_NEAR(LargestStablePeriod(Sampled(20480, PanelUnit::kVoltPerMm)), 12.02e-3, 5e-6);
}

TEST(Regimes, AnUnstableLoopIsRefusedWithTheLargestPeriod) {
  SampledAxis axis = Sampled(20480, PanelUnit::kEncoderPulse);
  axis.period_s = 0.0004;
  const auto refused = Simulate(axis, std::vector<double>(10, 0.0));
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidValue);
  EXPECT_NE(refused.error().message.find("2.446e-05 s"), std::string::npos)
      << refused.error().message;
}

// Below the limit the sampled loop comes to its command, above it would not: the limit is
// that of the stepping itself.
TEST(Regimes, TheLimitOfThePeriodIsThatOfTheStepping) {
  SampledAxis axis = Sampled(20480, PanelUnit::kVoltPerMm);
  axis.period_s = 0.95 * LargestStablePeriod(axis);
  const auto samples = Simulate(axis, std::vector<double>(2000, 0.0));
  ASSERT_TRUE(samples.has_value());
  std::vector<double> step(2000, 0.001);
  step.front() = 0;
  const auto settled = Simulate(axis, step);
  EXPECT_NEAR(settled->back().position_m, 0.001, 1e-9);
}

}  // namespace
}  // namespace intaglio::drive
