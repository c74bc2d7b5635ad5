#include "engrave/drive/sampled_axis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "engrave/drive/continuous_axis.h"

namespace intaglio::drive {
namespace {

/// K 100 1/s, tau 4 ms.
SampledAxis Axis(double period_s) {
  SampledAxis axis;
  axis.speed_per_volt = 0.05;
  axis.velocity_time_s = 0.004;
  axis.loop = {2000, 0, 0};
  axis.period_s = period_s;
  return axis;
}

std::vector<double> Ramp(double speed_m_s, double period_s, double duration_s) {
  std::vector<double> setpoints;
  for (double t = 0; t < duration_s; t += period_s) setpoints.push_back(speed_m_s * t);
  return setpoints;
}

TEST(SampledAxis, ComesToTheContinuousAxisWithItsPeriod) {
  ContinuousAxis continuous({100, 0.004, 0, 0}, 0, 0);
  const Cubic step = {0.001, 0, 0, 0};
  continuous.Follow(step, 0.03);
  double last = 1;
  for (const double period_s : {1e-3, 1e-4, 1e-5}) {
    std::vector<double> setpoints(static_cast<std::size_t>(0.03 / period_s + 1.5), 0.001);
    setpoints.front() = 0.001;
    SampledAxis axis = Axis(period_s);
    // From rest at 0: the first setpoint is where it rests.
    setpoints.insert(setpoints.begin(), 0.0);
    const auto samples = Simulate(axis, setpoints).value();
    const double error = std::abs(samples.back().position_m - continuous.position());
    EXPECT_LT(error, 0.2 * last) << period_s;
    last = error;
  }
  EXPECT_LT(last, 1e-6);
}

// With constant voltage between samples the speed is known at every sample: an
// integration in thousandths of the period.
TEST(SampledAxis, StepsExactlyWhateverThePeriod) {
  SampledAxis axis = Axis(0.002);
  axis.load_m_s2 = 0.3;
  std::vector<double> setpoints = Ramp(0.05, axis.period_s, 0.2);
  const auto samples = Simulate(axis, setpoints).value();
  double x = 0, v = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    ASSERT_NEAR(samples[i].position_m, x, 1e-9) << i;
    ASSERT_NEAR(samples[i].speed_m_s, v, 1e-7) << i;
    const double volt = 2000 * (setpoints[i] - x);
    EXPECT_NEAR(samples[i].volt, volt, 1e-5);
    const double h = axis.period_s / 4000;
    for (int k = 0; k < 4000; ++k) {
      const auto a = [&](double speed) { return (0.05 * volt - speed) / 0.004 - 0.3; };
      const double middle = v + h / 2 * a(v);
      x += h * middle;
      v += h * a(middle);
    }
  }
}

TEST(SampledAxis, LagAndStaticErrorAreThoseOfTheClosedForms) {
  SampledAxis axis = Axis(0.0005);
  const auto ramp = Simulate(axis, Ramp(0.08, axis.period_s, 1)).value();
  // Half a period more: the reference is held.
  EXPECT_NEAR(ramp.back().following_error_m, 0.08 / 100, 1e-9);
  axis.load_m_s2 = 0.5;
  const auto loaded = Simulate(axis, std::vector<double>(4000, 0.0)).value();
  EXPECT_NEAR(loaded.back().following_error_m, StaticError({100, 0.004, 0, 0}, 0.5),
              1e-12);
}

TEST(SampledAxis, AFeedForwardOfOneLeavesNoLag) {
  SampledAxis axis = Axis(0.0005);
  axis.loop.feed_forward_ratio = 1;
  const auto ramp = Simulate(axis, Ramp(0.08, axis.period_s, 1)).value();
  EXPECT_NEAR(ramp.back().following_error_m, 0, 1e-9);
}

TEST(SampledAxis, FrictionHoldsWithinItsDeadBand) {
  SampledAxis axis = Axis(0.0005);
  axis.friction_m_s2 = 0.4;
  const double band_m = StaticError({100, 0.004, 0, 0}, 0.4);
  std::vector<double> small(2000, 0.9 * band_m);
  small.front() = 0;
  EXPECT_EQ(Simulate(axis, small)->back().position_m, 0);
  std::vector<double> move(4000, 0.02);
  move.front() = 0;
  const auto moved = Simulate(axis, move).value();
  EXPECT_EQ(moved.back().speed_m_s, 0);
  EXPECT_GT(std::abs(moved.back().following_error_m), 0);
  EXPECT_LE(std::abs(moved.back().following_error_m), band_m);
}

// Work of the motor against friction and inertia, in units of the mass: the integral of
// the drive's pull over the way is kinetic energy and friction times way.
TEST(SampledAxis, FrictionTakesItsWorkAndNoMore) {
  SampledAxis axis = Axis(0.0005);
  axis.loop = {1e-9, 0, 0};  // nothing drives it
  axis.friction_m_s2 = 0.4;
  axis.load_m_s2 = -2;  // and then nothing but the load does
  const auto samples = Simulate(axis, std::vector<double>(400, 0.0)).value();
  // x'' = -x' / tau + 2 - .4: it comes to 1.6 tau.
  EXPECT_NEAR(samples.back().speed_m_s, 1.6 * 0.004, 1e-9);
}

TEST(SampledAxis, TheConverterRoundsAndLimits) {
  SampledAxis axis = Axis(0.0005);
  axis.volt_per_step = 0.5;
  axis.max_volt = 3;
  std::vector<double> step(200, 0.01);
  step.front() = 0;
  const auto samples = Simulate(axis, step).value();
  for (const AxisSample& s : samples) {
    EXPECT_LE(std::abs(s.volt), 3);
    EXPECT_EQ(std::round(s.volt / 0.5), s.volt / 0.5);
  }
  EXPECT_EQ(samples[1].volt, 3);
}

TEST(SampledAxis, TheEncoderIsReadInWholeCounts) {
  SampledAxis axis = Axis(0.0005);
  axis.counts_per_m = 10000;  // 0.1 mm
  std::vector<double> step(4000, 0.00034);
  step.front() = 0;
  const auto samples = Simulate(axis, step).value();
  // It swings about the place where the count changes: 0.34 mm is between 0.3 and 0.4.
  const double read = std::round(samples.back().position_m * 10000) / 10000;
  EXPECT_NEAR(samples.back().volt, 2000 * (0.00034 - read), 1e-9);
  EXPECT_NEAR(samples.back().position_m, 0.00035, 0.00002);
}

// tau x'' + x' = K (r - x): multiplied by x' and integrated, the pull's work is kinetic
// energy and what the viscous term takes.
TEST(SampledAxis, EnergyIsKept) {
  SampledAxis axis = Axis(0.00002);
  std::vector<double> step(20000, 0.001);
  step.front() = 0;
  const auto samples = Simulate(axis, step).value();
  double work = 0, loss = 0;
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    const double v = samples[i].speed_m_s, next = samples[i + 1].speed_m_s;
    const double moved = samples[i + 1].position_m - samples[i].position_m;
    work += 0.05 * samples[i].volt * moved / 0.004;
    loss += (v * v + v * next + next * next) / 3 * axis.period_s / 0.004;
  }
  const double kinetic = 0.5 * samples.back().speed_m_s * samples.back().speed_m_s;
  EXPECT_NEAR(work, loss + kinetic, 1e-5 * work);
}

}  // namespace
}  // namespace intaglio::drive
