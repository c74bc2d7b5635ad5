// The guarantees of engrave/drive/drive.h, numbered as there, for every row of DriveKinds
// over the corners and the middle of its parameters. The equation of each kind is written
// here once more, and integrated by Runge-Kutta.

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "engrave/drive/drive_kinds.h"

namespace intaglio::drive {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

/// x, x' and further states of the equation.
using State = std::array<double, 5>;

struct Equation {
  std::function<State(const State&, double command_u, double command_u_s)> slope;
  double fastest_s = 0;          ///< the shortest time constant; 0: none
  double slowest_s = 0;          ///< what is left of the past is below e^-1 after it
  bool starts_anywhere = false;  ///< position and speed are all of its state
};

Equation FirstOrderEquation(double lag_s) {
  return {
      [lag_s](const State& at, double c, double) { return State{(c - at[0]) / lag_s}; },
      lag_s, lag_s, true};
}

Equation SecondOrderEquation(double frequency_hz, double d) {
  const double w = kTwoPi * frequency_hz;
  const double slow_rate = d < 1 ? d * w : w * (d - std::sqrt(d * d - 1));
  const double fast_rate = d < 1 ? w : w * (d + std::sqrt(d * d - 1));
  return {[w, d](const State& at, double c, double) {
            return State{at[1], w * w * (c - at[0]) - 2 * d * w * at[1]};
          },
          1 / fast_rate, 1 / slow_rate, true};
}

Equation ServoEquation(double k, double tau, double d, double f) {
  return {[=](const State& at, double c, double c_s) {
    return State{at[1], (k * (c - at[0]) + d * (c_s - at[1]) + f * c_s - at[1]) / tau};
  }};
}

// Each loop as it is built: the current loop, the velocity loop around it, the position
// loop around both, and what is carried behind them.
Equation CascadeEquation(double k, double frequency_hz, double d) {
  const double m = kTwoPi * frequency_hz;
  return {[=](const State& at, double c, double) {
    const double speed = k * (c - at[2]), acceleration = 3 * k * (speed - at[3]);
    return State{at[1], m * m * (at[2] - at[0]) - 2 * d * m * at[1], at[3], at[4],
                 12 * k * (acceleration - at[4])};
  }};
}

Equation StepperEquation(const std::vector<double>& v) {
  const double p = kTwoPi * v[0], d1 = v[1], q = kTwoPi * v[2], d2 = v[3], m = v[4];
  return {[=](const State& at, double c, double) {
    const double f = q * q * (at[2] - at[0]) + 2 * d2 * q * (at[3] - at[1]);
    return State{at[1], f, at[3], p * p * (c - at[2]) - 2 * d1 * p * at[3] - m * f};
  }};
}

// Third to fifth state: the integral of the error, what is held, the error of
// differences.
Equation PlanarEquation(const std::vector<double>& v) {
  const double w = kTwoPi * v[0], d = v[1], r = v[2], late_s = v[3] / 2, ki = w * w * r;
  const double kp = w * w + 2 * d * w * r + ki * late_s, kd = 2 * d * w + r;
  return {[=](const State& at, double c, double) {
    const double error = c - at[0], error_s = (error - at[4]) / late_s;
    const double asked = kp * error + ki * at[2] + kd * error_s;
    return State{at[1], at[3], error, (asked - at[3]) / late_s, error_s};
  }};
}

/// By the roots of the denominator.
void SetTimes(const Transfer& transfer, Equation& equation) {
  const auto n = static_cast<Eigen::Index>(OrderOf(transfer.denominator));
  const double unit_s =
      std::pow(transfer.denominator[static_cast<std::size_t>(n)], 1.0 / double(n));
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (i > 0) companion(i, i - 1) = 1;
    companion(i, n - 1) =
        -transfer.denominator[static_cast<std::size_t>(i)] / std::pow(unit_s, double(i));
  }
  const Eigen::VectorXcd roots = companion.eigenvalues();
  ASSERT_LT(roots.real().maxCoeff(), 0) << "not stable";
  equation.slowest_s = -unit_s / roots.real().maxCoeff();
  equation.fastest_s = unit_s / roots.cwiseAbs().maxCoeff();
}

Equation EquationOf(const Drive& drive, const std::vector<double>& values) {
  const std::string_view name = drive.name();
  if (name == "first_order") return FirstOrderEquation(values[0]);
  if (name == "second_order") return SecondOrderEquation(values[0], values[1]);
  Equation equation;
  if (name == "servo")
    equation = ServoEquation(values[0], values[1], values[2], values[3]);
  if (name == "cascade") equation = CascadeEquation(values[0], values[1], values[2]);
  if (name == "stepper_screw") equation = StepperEquation(values);
  if (name == "planar_drive") equation = PlanarEquation(values);
  EXPECT_TRUE(equation.slope) << "write the equation of the new kind here";
  SetTimes(drive.transfer(), equation);
  return equation;
}

State Along(State from, const State& by, double factor) {
  for (std::size_t i = 0; i < from.size(); ++i) from[i] += factor * by[i];
  return from;
}

State Integrate(const Equation& equation, State at, const Cubic& command,
                double duration_s) {
  const int steps = static_cast<int>(std::ceil(duration_s / (equation.fastest_s / 100)));
  const double h = duration_s / steps;
  const auto slope = [&](const State& state, double t) {
    return equation.slope(state, command.At(t), command.VelocityAt(t));
  };
  for (int i = 0; i < steps; ++i) {
    const double t = i * h;
    const State k1 = slope(at, t);
    const State k2 = slope(Along(at, k1, h / 2), t + h / 2);
    const State k3 = slope(Along(at, k2, h / 2), t + h / 2);
    const State k4 = slope(Along(at, k3, h), t + h);
    for (const auto& [by, weight] : {std::pair(k1, 1), {k2, 2}, {k3, 2}, {k4, 1}})
      at = Along(at, by, weight * h / 6);
  }
  return at;
}

/// One kind with one set of parameters.
struct Sample {
  const DriveKind* kind = nullptr;
  std::vector<double> values;
  std::shared_ptr<const Drive> drive;
  Equation equation;
  std::string Text() const {
    std::string text(kind->name);
    for (const double value : values) text += " " + std::to_string(value);
    return text;
  }
};

/// Ends and geometric middle of each parameter, all combinations; of many 40.
std::vector<Sample> Samples() {
  std::vector<Sample> samples;
  for (const DriveKind& kind : DriveKinds()) {
    std::vector<std::vector<double>> all = {{}};
    for (const DriveParameter& parameter : kind.parameters) {
      std::vector<std::vector<double>> longer;
      for (const auto& values : all) {
        const double low = std::max(parameter.min, 1e-4 * parameter.max);
        for (const double value : {parameter.min, std::sqrt(low * parameter.max),
                                   parameter.max, std::min(1.0, parameter.max)}) {
          longer.push_back(values);
          longer.back().push_back(value);
        }
      }
      all = longer;
    }
    std::shuffle(all.begin(), all.end(), std::mt19937_64(7));
    if (all.size() > 40) all.resize(40);
    for (const auto& values : all) {
      auto made = MakeDrive(kind.name, values);
      if (!made && kind.check != nullptr) continue;  // drive_kinds_test.cc
      EXPECT_TRUE(made.has_value()) << made.error().message;
      samples.push_back({&kind, values, *made, EquationOf(**made, values)});
    }
  }
  return samples;
}

/// Courses of a stage: +-80 mm/s, 7 m/s^2 and the jerk that reverses it in 5 ms.
std::vector<Cubic> Courses() {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> ratio(-1, 1);
  std::vector<Cubic> courses = {{}, {3, 0, 0, 0}, {0, 80, 0, 0}, {0, 0, 7000, 0}};
  for (int i = 0; i < 20; ++i) {
    courses.push_back({170 * ratio(random), 80 * ratio(random), 7000 * ratio(random),
                       2.8e6 * ratio(random)});
  }
  return courses;
}

/// Sizes that roundings are measured by: of the command and of the coefficients that the
/// drive adds to it.
double SizeOf(const Cubic& a, double t_s) {
  return 1 + std::abs(a.position_u) + t_s * std::abs(a.velocity_u_s) +
         t_s * t_s * std::abs(a.acceleration_u_s2) +
         t_s * t_s * t_s * std::abs(a.jerk_u_s3);
}

TEST(DriveConformance, FollowSolvesTheEquation) {  // 1
  for (const Sample& sample : Samples()) {
    const Equation& equation = sample.equation;
    if (equation.fastest_s <= 0) continue;  // no lag: see below
    // Some time constants, within what the integration can do in a moment.
    const bool anywhere = equation.starts_anywhere;
    const double duration_s =
        std::min(3 * equation.slowest_s, (anywhere ? 400 : 40) * equation.fastest_s);
    for (const Cubic& command : Courses()) {
      // Rest at the command's begin is a state that every drive has.
      const double from_u = command.position_u;
      const AxisState from = anywhere ? AxisState{from_u + 0.5, 12}
                                      : sample.drive->SettledState({from_u, 0, 0, 0});
      State state = anywhere ? State{from_u + 0.5, 12} : State{from_u};
      if (sample.kind->name == "cascade" || sample.kind->name == "stepper_screw")
        state[2] = from_u;
      const State expected = Integrate(equation, state, command, duration_s);
      const AxisState actual = sample.drive->Follow(from, command, duration_s);
      // Steps of a hundredth of a time constant: 1e-9 of what moves.
      EXPECT_NEAR(actual.position_u, expected[0],
                  1e-8 * SizeOf(command, duration_s + equation.slowest_s))
          << sample.Text();
      if (sample.kind->name == "first_order") continue;
      EXPECT_NEAR(actual.velocity_u_s * equation.fastest_s,
                  expected[1] * equation.fastest_s,
                  1e-8 * SizeOf(command, duration_s + equation.slowest_s))
          << sample.Text();
    }
  }
}

double AccelerationOf(const Cubic& course, double t_s) {
  return course.acceleration_u_s2 + t_s * course.jerk_u_s3;
}

TEST(DriveConformance, TwoStepsAreOne) {  // 1
  for (const Sample& sample : Samples()) {
    for (const Cubic& command : Courses()) {
      for (const double share : {0.01, 0.5, 0.9}) {
        const double duration_s = 0.004;
        const double first_s = share * duration_s;
        const AxisState from =
            sample.drive->SettledState({command.position_u - 0.3, -20, 0, 0});
        const AxisState middle = sample.drive->Follow(from, command, first_s);
        const Cubic later = {command.At(first_s), command.VelocityAt(first_s),
                             AccelerationOf(command, first_s), command.jerk_u_s3};
        const AxisState twice = sample.drive->Follow(middle, later, duration_s - first_s);
        const AxisState once = sample.drive->Follow(from, command, duration_s);
        const double size = SizeOf(command, duration_s + sample.equation.slowest_s);
        EXPECT_NEAR(twice.position_u, once.position_u, 1e-9 * size) << sample.Text();
      }
    }
  }
}

TEST(DriveConformance, RestStaysRest) {  // 2
  for (const Sample& sample : Samples()) {
    for (const double duration_s : {1e-6, 0.01, 1.0, 1000.0}) {
      const Cubic command = {42.5, 0, 0, 0};
      const AxisState rest =
          sample.drive->Follow(sample.drive->SettledState(command), command, duration_s);
      EXPECT_DOUBLE_EQ(rest.position_u, 42.5) << sample.Text();
      EXPECT_NEAR(rest.velocity_u_s, 0, 1e-9) << sample.Text();
    }
  }
}

TEST(DriveConformance, ItIsStableAndComesToTheSettledCourse) {  // 3
  for (const Sample& sample : Samples()) {
    for (const Cubic& command : Courses()) {
      // e^-40 of 1 u and 1000 u/s is nothing.
      const double duration_s = 40 * sample.equation.slowest_s;
      const Cubic settled = sample.drive->Settled(command);
      const AxisState end = sample.drive->Follow(
          sample.drive->SettledState({command.position_u + 1, 1000, 0, 0}), command,
          duration_s);
      EXPECT_NEAR(end.position_u, settled.At(duration_s),
                  1e-9 * (SizeOf(command, duration_s + sample.equation.slowest_s) +
                          SizeOf(settled, duration_s)))
          << sample.Text();
    }
  }
}

TEST(DriveConformance, TheSettledCourseIsKeptAndTheErrorIsAsPredicted) {  // 4, 6
  for (const Sample& sample : Samples()) {
    for (const Cubic& command : Courses()) {
      const Cubic settled = sample.drive->Settled(command);
      const AxisState state = sample.drive->SettledState(command);
      const double size =
          SizeOf(command, 0.02 + sample.equation.slowest_s) + SizeOf(settled, 0.02);
      EXPECT_NEAR(state.position_u, settled.position_u, 1e-12 * size) << sample.Text();
      for (const double t_s : {0.001, 0.005, 0.02}) {
        const AxisState at = sample.drive->Follow(state, command, t_s);
        EXPECT_NEAR(at.position_u, settled.At(t_s), 1e-9 * size) << sample.Text();
        EXPECT_NEAR(at.position_u - command.At(t_s), sample.drive->Error(command, t_s),
                    1e-9 * size)
            << sample.Text();
      }
    }
  }
}

TEST(DriveConformance, TheInverseKeepsTheAxisOnItsCourse) {  // 5
  for (const Sample& sample : Samples()) {
    for (const Cubic& course : Courses()) {
      const Cubic command = sample.drive->CommandFor(course);
      const double size =
          SizeOf(command, 0.02 + sample.equation.slowest_s) + SizeOf(course, 0.02);
      const AxisState state = sample.drive->SettledState(command);
      EXPECT_NEAR(state.position_u, course.position_u, 1e-9 * size);
      for (const double t_s : {0.001, 0.005, 0.02}) {
        EXPECT_NEAR(sample.drive->Follow(state, command, t_s).position_u, course.At(t_s),
                    1e-9 * size)
            << sample.Text();
      }
      const Cubic back = sample.drive->Settled(command);
      EXPECT_NEAR(back.At(0.01), course.At(0.01), 1e-9 * size) << sample.Text();
    }
  }
}

TEST(DriveConformance, CommandsOfABrakingCourseKeepTheirLead) {  // lead_s2
  for (const Sample& sample : Samples()) {
    // With transients of zeros: tests/engrave/motion/commands/error_prediction_test.cc.
    const Transfer transfer = sample.drive->transfer();
    const std::size_t zeros = OrderOf(transfer.numerator);
    if (zeros == 2 || (zeros > 0 && zeros + 1 == OrderOf(transfer.denominator))) continue;
    const double braking_u_s2 = 7000;
    const double bound_u = sample.drive->lead_s2() * braking_u_s2;
    double largest_u = 0;
    for (double v = 0; v < 20000; v = 1.01 * v + 0.01) {
      // The place of rest is 0; on the way there the course may still accelerate.
      const double at_u = -v * v / (2 * braking_u_s2);
      for (const double a : {-braking_u_s2, braking_u_s2}) {
        largest_u =
            std::max(largest_u, sample.drive->CommandFor({at_u, v, a, 0}).position_u);
      }
    }
    EXPECT_LE(largest_u, bound_u * (1 + 1e-9) + 1e-12) << sample.Text();
    EXPECT_GE(largest_u, 0.99 * bound_u - 1e-9) << "a bound that wastes travel";
  }
}

TEST(DriveConformance, TheInverseAddsFixedMultiplesOfTheDerivatives) {  // 8
  for (const Sample& sample : Samples()) {
    const double of_velocity_s = sample.drive->CommandFor({0, 1, 0, 0}).position_u;
    const double of_acceleration_s2 = sample.drive->CommandFor({0, 0, 1, 0}).position_u;
    const double of_jerk_s3 = sample.drive->CommandFor({0, 0, 0, 1}).position_u;
    const Transfer transfer = sample.drive->transfer();
    const auto series = SeriesOf(transfer.denominator, transfer.numerator);
    EXPECT_DOUBLE_EQ(of_velocity_s, series[1]) << sample.Text();
    EXPECT_DOUBLE_EQ(of_acceleration_s2, series[2]) << sample.Text();
    EXPECT_DOUBLE_EQ(of_jerk_s3, series[3]) << sample.Text();
    for (const Cubic& course : Courses()) {
      const Cubic command = sample.drive->CommandFor(course);
      for (const double t_s : {0.0, 0.003, 0.02}) {
        const double v = course.VelocityAt(t_s), a = AccelerationOf(course, t_s);
        const double j = course.jerk_u_s3;
        const double size = SizeOf(command, 0.02) + SizeOf(course, 0.02);
        EXPECT_NEAR(
            command.At(t_s),
            course.At(t_s) + of_velocity_s * v + of_acceleration_s2 * a + of_jerk_s3 * j,
            1e-12 * size)
            << sample.Text();
        EXPECT_NEAR(command.VelocityAt(t_s),
                    v + of_velocity_s * a + of_acceleration_s2 * j, 1e-9 * size)
            << sample.Text();
      }
    }
  }
}

TEST(DriveConformance, WhatIsOutsideTheRangesIsRefusedWithItsName) {  // 7
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (const DriveKind& kind : DriveKinds()) {
    std::vector<double> good;
    for (const DriveParameter& parameter : kind.parameters) good.push_back(parameter.max);
    for (std::size_t i = 0; i < good.size(); ++i) {
      const DriveParameter& parameter = kind.parameters[i];
      for (const double wrong :
           {std::nextafter(parameter.min, -1.0), -1.0,
            std::nextafter(parameter.max, kInfinite), kNan, kInfinite, -kInfinite}) {
        auto values = good;
        values[i] = wrong;
        const auto made = MakeDrive(kind.name, values);
        ASSERT_FALSE(made.has_value()) << kind.name << " " << wrong;
        EXPECT_NE(made.error().message.find(std::string(parameter.name)),
                  std::string::npos)
            << made.error().message;
      }
    }
  }
}

}  // namespace
}  // namespace intaglio::drive
