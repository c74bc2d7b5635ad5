#include "services/virtual_engraver/mechanics/loop_axis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "engrave/drive/drive_kinds.h"

namespace intaglio::virtual_engraver {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

/// Courses of a stage from rest at 3 mm, one after the other, 10 ms each.
std::vector<AxisCommand> Courses() {
  return {{3, 0, 3500, 0}, {3.35, 70, 0, -1.2e5}, {3.93, 34, -2000, 3e4}, {4.1, 3, 0, 0}};
}

/// The largest difference between an axis and the closed form of its drive, over commands
/// that jump a little between them; the drive's code shares nothing with the axis'.
double LargestDifference(const LoopOptions& options, const char* kind,
                         const std::vector<double>& values) {
  const auto drive = drive::MakeDrive(kind, values).value();
  LoopAxis axis(options, 3);
  drive::AxisState state = drive->SettledState({3, 0, 0, 0});
  double largest = 0;
  for (const AxisCommand& c : Courses()) {
    double at_s = 0;
    for (const double to_s : {0.0013, 0.0057, 0.01}) {
      const drive::Cubic command = {c.At(at_s), c.SpeedAt(at_s),
                                    2 * c.c2 + 6 * at_s * c.c3, 6 * c.c3};
      axis.Follow(c, at_s, to_s);
      state = drive->Follow(state, command, to_s - at_s);
      at_s = to_s;
      largest = std::max(largest, std::abs(axis.actual() - state.position_u));
    }
  }
  return largest;
}

// Commands go on over knots here: a jump sets off the derivative of a servo as a pulse,
// which an integration of its equation does not have.
TEST(LoopAxis, IsItsDriveWhereThatIsLinear) {
  // The error of the steps, 1e-7 of what moves.
  EXPECT_LT(LargestDifference(CascadeOptions{150, 120, 0.6}, "cascade", {150, 120, 0.6}),
            1e-6);
  EXPECT_LT(
      LargestDifference(ServoOptions{100, 0.003, 0, 0}, "servo", {100, 0.003, 0, 0}),
      1e-6);
  // A field so wide that its sine is a line: 1 - cos of 1 mm in 40 m.
  EXPECT_LT(LargestDifference(StepperOptions{80, 0.4, 200, 0.1, 0.7, 10000},
                              "stepper_screw", {80, 0.4, 200, 0.1, 0.7}),
            1e-6);
}

TEST(LoopAxis, AServoWithDerivativeAndFeedForwardIsItsDrive) {
  const auto drive =
      drive::MakeDrive("servo", std::vector{300.0, 0.004, 0.5, 0.8}).value();
  LoopAxis axis(ServoOptions{300, 0.004, 0.5, 0.8}, 0);
  const AxisCommand c = {0, 0, 3500, -1e5};
  axis.Follow(c, 0, 0.02);
  EXPECT_NEAR(axis.actual(),
              drive->Follow(drive->SettledState({}), {0, 0, 7000, -6e5}, 0.02).position_u,
              1e-7);
}

// The controller's period adds half of itself and the hold another half: at 50 Hz and
// 0.2 ms that is 0.06 rad. The drive has both as lags of first order; commands of an axis
// at rest that begin between two samples are another half period late.
TEST(LoopAxis, APlanarAxisIsItsDriveOfTheSamePeriod) {
  const auto with = [](double period_s) {
    PlanarOptions options{50, 0.7, 20};
    options.period_s = period_s;
    options.tooth_period_mm = 1e-6;  // a division of 0.24 pm
    return LargestDifference(options, "planar_drive", {50, 0.7, 20, period_s});
  };
  const double coarse = with(0.0002), fine = with(0.00002);
  EXPECT_LT(coarse, 0.05);
  EXPECT_LT(fine, 0.2 * coarse);
}

TEST(LoopAxis, AtConstantSpeedItIsLateByItsVelocityLag) {
  for (const LoopOptions& options :
       {LoopOptions(ServoOptions{200, 0.003, 0.2, 0.6}), LoopOptions(CascadeOptions{}),
        LoopOptions(StepperOptions{100, 0.5, 200, 0.1, 0.5, 10}),
        LoopOptions(PlanarOptions{50, 0.7, 30})}) {
    LoopAxis axis(options, 0);
    const AxisCommand ramp = {0, 20, 0, 0};
    axis.Follow(ramp, 0, 1);
    // What is left: the sine of the field, the division of the sensor.
    EXPECT_NEAR(axis.actual(), ramp.At(1 - axis.velocity_lag_s()), 4e-4)
        << options.index();
  }
}

// Static error: tau a / K, whatever turns it away (drives.md: M R / (Kt Ka Kp Kc u)).
TEST(LoopAxis, ALoadDisplacesAServoByItsStaticError) {
  LoopAxis axis(ServoOptions{150, 0.004, 0, 0, 600}, 0);
  axis.Follow({}, 0, 3);
  EXPECT_NEAR(axis.actual(), -0.004 * 600 / 150, 1e-9);
}

TEST(LoopAxis, FrictionLeavesAServoWithinItsDeadBand) {
  const ServoOptions options{150, 0.004, 0, 0, 0, 900};
  const double band = 0.004 * 900 / 150;
  LoopAxis axis(options, 0);
  axis.Follow({0.9 * band}, 0, 0.5);
  EXPECT_EQ(axis.actual(), 0) << "the pull is below the friction";
  axis.Follow({5, 0, 0, 0}, 0, 2);
  const double rest = axis.actual();
  EXPECT_GT(std::abs(rest - 5), 1e-6) << "friction stops it before the end";
  EXPECT_LT(std::abs(rest - 5), band);
  axis.Follow({5, 0, 0, 0}, 0, 1);
  EXPECT_EQ(axis.actual(), rest) << "it sticks";
}

TEST(LoopAxis, AMotorAtItsLimitAcceleratesByItAndNoMore) {
  ServoOptions options{50, 0.001};
  options.max_acceleration_mm_s2 = 2000;
  LoopAxis axis(options, 0);
  axis.Follow({100}, 0, 0.002);  // 100 mm away: far above the limit all the time
  EXPECT_NEAR(axis.actual(), 0.5 * 2000 * 0.002 * 0.002, 1e-12);
}

// The field holds w^2 times 2 full steps / pi. Below it the rotor arrives; above it slips
// by whole periods of four full steps and the axis stays where it came to.
TEST(LoopAxis, AStepperLosesStepsAboveItsTorqueAndOnlyThere) {
  const StepperOptions options{60, 0.3, 400, 0.3, 0, 0.025};
  const double w = kTwoPi * 60, holds = w * w * 2 * 0.025 / std::numbers::pi;
  for (const double ratio : {0.2, 3.0}) {
    LoopAxis axis(options, 0);
    const double a = ratio * holds, t_s = 0.02;
    axis.Follow({0, 0, a / 2, 0}, 0, t_s);
    axis.Follow({a / 2 * t_s * t_s, a * t_s, -a / 2, 0}, 0, t_s);
    const double end = a * t_s * t_s;
    axis.Follow({end}, 0, 2);
    const double lost_periods = (end - axis.actual()) / (4 * 0.025);
    EXPECT_NEAR(lost_periods, std::round(lost_periods), 1e-6);
    EXPECT_EQ(std::round(lost_periods) >= 1, ratio > 1) << lost_periods;
  }
}

// The loop's answer to a disturbance of acceleration is s / (s^3 + kd s^2 + kp s + ki).
TEST(LoopAxis, CoggingMovesAPlanarAxisAsItsLoopLetsIt) {
  PlanarOptions options{40, 0.7, 10};
  options.period_s = 0.0001;
  options.cogging_mm_s2 = 300;
  LoopAxis axis(options, 0);
  const double speed = 20, omega = kTwoPi * speed / options.tooth_period_mm;
  const AxisCommand ramp = {0, speed, 0, 0};
  axis.Follow(ramp, 0, 1);
  double min = 1, max = -1;
  for (double at_s = 1; at_s < 1.2; at_s += 0.0005) {
    axis.Follow(ramp, at_s, at_s + 0.0005);
    const double error = axis.actual() - ramp.At(at_s + 0.0005);
    min = std::min(min, error), max = std::max(max, error);
  }
  const double w = kTwoPi * 40;
  const std::complex<double> s(0, omega);
  const double amplitude =
      std::abs(300.0 * s / ((s * s + 2 * 0.7 * w * s + w * w) * (s + 10.0)));
  // 7 %: the period of the controller turns the loop by omega 0.1 ms = 0.02 rad and w
  // 0.1 ms = 0.025, and the sensor's division is 0.16 um of 3.
  EXPECT_NEAR((max - min) / 2, amplitude, 0.07 * amplitude);
}

TEST(LoopAxis, APlanarAxisBelievesItsSensor) {
  PlanarOptions options{40, 0.7, 40};
  options.sensor_error_mm = 0.005;
  LoopAxis axis(options, 0);
  axis.Follow({0.08}, 0, 0.3);  // an eighth of the tooth: the error is at its largest
  axis.Follow({0.08}, 0, 2);
  const double x = axis.actual();
  const double read = x + 0.005 * std::sin(2 * kTwoPi * x / 0.64);
  EXPECT_NEAR(read, 0.08, 0.64 / 4096);
  EXPECT_GT(std::abs(x - 0.08), 0.004);
}

TEST(LoopAxis, AtRestItStaysWithoutASpeed) {
  LoopAxis axis(ServoOptions{100, 0.003}, 0);
  axis.Follow({10}, 0, 0.01);
  const double held = axis.actual();
  axis.Rest();
  axis.Follow({held}, 0, 0.5);
  EXPECT_EQ(axis.actual(), held);
}

}  // namespace
}  // namespace intaglio::virtual_engraver
