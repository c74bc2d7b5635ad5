// Circles and corners of two axes, against closed forms of linear axes: a circle shrinks
// by the amplitude of each axis at its frequency, and equal axes that lag by a time T
// pass a corner of 90 degrees inside by the largest of their exponential lags.

#include "engrave/drive/two_axes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "engrave/core/check.h"

namespace intaglio::drive {
namespace {

using std::numbers::pi;

/// tau x'' + x' = g U with volt_per_m: gain K = g volt_per_m, a period that is short.
SampledAxis AxisOf(double gain_per_s) {
  SampledAxis axis;
  axis.speed_per_volt = 0.05;
  axis.velocity_time_s = 0.0005;
  axis.loop.volt_per_m = gain_per_s / axis.speed_per_volt;
  axis.period_s = 2e-5;
  return axis;
}

/// x / r of tau x'' + x' = K (r - x) at a frequency.
std::complex<double> Follows(double gain_per_s, double omega) {
  const std::complex<double> s(0, omega);
  return gain_per_s / (0.0005 * s * s + s + gain_per_s);
}

TEST(TwoAxes, EqualAxesTurnACircleOfTheirAmplitude) {
  const double radius = 0.01, speed = 0.1, k = 200;
  const auto run = SimulateCircle({AxisOf(k), AxisOf(k)}, {radius, speed, 3});
  ASSERT_TRUE(run) << run.error().message;
  const double shrinks = radius * (1 - std::abs(Follows(k, speed / radius)));
  EXPECT_NEAR(run->settled_inside_m, shrinks, 0.02 * shrinks);
  EXPECT_LT(run->settled_outside_m, 1e-7);
}

TEST(TwoAxes, UnequalAxesTurnAnEllipse) {
  const double radius = 0.022, speed = 2.0 / 60, k1 = 200, k2 = 240;
  const auto run = SimulateCircle({AxisOf(k1), AxisOf(k2)}, {radius, speed, 2});
  ASSERT_TRUE(run) << run.error().message;
  // By dense sampling of the two settled sines.
  const auto x = Follows(k1, speed / radius), y = Follows(k2, speed / radius);
  double out = 0, in = 0;
  for (double t = 0; t < 2 * pi; t += 1e-4) {
    const std::complex<double> turn = std::polar(1.0, t);
    const double off = radius * (std::hypot((x * turn).real(), (y * turn).imag()) - 1);
    out = std::max(out, off), in = std::max(in, -off);
  }
  EXPECT_NEAR(run->settled_outside_m, out, 0.03 * out);
  EXPECT_NEAR(run->settled_inside_m, in, 0.03 * in);
}

TEST(TwoAxes, ACornerAtFullSpeedIsCutInsideAndAStopKeepsIt) {
  const TwoAxes axes = {AxisOf(200), AxisOf(200)};
  CornerCourse course{0.03, 0.1, 5, pi / 2, false, 0.1};
  const auto passed = SimulateCorner(axes, course);
  ASSERT_TRUE(passed);
  // Axes of first order: x = v T exp(-t/T) short of the corner, y = v (t - T (1 -
  // exp(-t/T))) behind it; the distance is the smaller of both, largest where they are
  // equal.
  const double lag = 1.0 / 200;
  double t = 0;
  while (t / lag - 1 + std::exp(-t / lag) < std::exp(-t / lag)) t += 1e-7;
  EXPECT_NEAR(passed->inside_m, 0.1 * lag * std::exp(-t / lag), 0.1 * 0.1 * lag);
  course.stops = true;
  const auto stopped = SimulateCorner(axes, course);
  ASSERT_TRUE(stopped);
  EXPECT_LT(stopped->inside_m, 0.2 * passed->inside_m);
  EXPECT_NEAR(stopped->axes[1].back().position_m, 0.03, 1e-6);
}

TEST(TwoAxes, ALoadLeavesItsErrorOnItsAxis) {
  TwoAxes axes = {AxisOf(200), AxisOf(200)};
  axes[1].load_m_s2 = 2;
  const auto run = SimulateCorner(axes, {0.01, 0.05, 2, pi / 2, true, 0.2});
  ASSERT_TRUE(run);
  // tau a = K e.
  EXPECT_NEAR(run->axes[1].back().following_error_m, 0.0005 * 2 / 200, 1e-8);
  EXPECT_NEAR(run->axes[0].back().following_error_m, 0, 1e-8);
}

TEST(TwoAxes, RefusesPeriodsThatDiffer) {
  TwoAxes axes = {AxisOf(200), AxisOf(200)};
  axes[1].period_s = 1e-5;
  EXPECT_THROW((void)SimulateCircle(axes, {0.01, 0.1, 1}), PreconditionError);
}

}  // namespace
}  // namespace intaglio::drive
