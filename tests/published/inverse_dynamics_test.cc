#include "tests/published/inverse_dynamics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engrave/core/check.h"

namespace intaglio::motion {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

const ColumnRobot kColumn{.inertia_kg_m2 = 0.8,
                          .lift_mass_kg = 3,
                          .arm_mass_kg = 2,
                          .turn_friction_n_m_s = 0.3,
                          .lift_friction_n_s_m = 5,
                          .arm_friction_n_s_m = 7};

/// Runge and Kutta, fourth order, with the controls of each instant.
template <typename Controls>
VectorXd Simulate(const AffinePlant& plant, VectorXd x, double seconds, int steps,
                  const Controls& controls) {
  const double h = seconds / steps;
  const auto rate = [&](double t, const VectorXd& at) {
    return plant.Rate(at, controls(t, at));
  };
  for (int i = 0; i < steps; ++i) {
    const double t = i * h;
    const VectorXd k1 = rate(t, x), k2 = rate(t + h / 2, x + h / 2 * k1);
    const VectorXd k3 = rate(t + h / 2, x + h / 2 * k2), k4 = rate(t + h, x + h * k3);
    x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return x;
}

TEST(ColumnRobot, WorkOfTheControlsAndTheFrictionsIsItsEnergy) {
  const AffinePlant plant = PlantOf(kColumn);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-2, 2);
  for (int trial = 0; trial < 200; ++trial) {
    VectorXd x(6), u(3);
    for (double& value : x) value = any(random);
    for (double& value : u) value = any(random);
    const VectorXd rate = plant.Rate(x, u);
    // dK/dt by differences along the motion, and the power that is put in.
    const double h = 1e-5;
    const double growth =
        (KineticEnergyJ(kColumn, x + h * rate) - KineticEnergyJ(kColumn, x - h * rate)) /
        (2 * h);
    const double power =
        (u[0] - 0.3 * x[1]) * x[1] + (u[1] - 5 * x[3]) * x[3] + (u[2] - 7 * x[5]) * x[5];
    EXPECT_NEAR(growth, power, 1e-6 * (1 + std::abs(power)));
  }
}

TEST(ColumnRobot, KeepsItsAngularMomentumWhenNothingTurnsIt) {
  ColumnRobot robot = kColumn;
  robot.turn_friction_n_m_s = 0;
  const AffinePlant plant = PlantOf(robot);
  VectorXd x(6);
  x << 0, 2, 0, 0, 0.3, 0;
  const auto momentum = [&](const VectorXd& at) {
    return (robot.inertia_kg_m2 + robot.arm_mass_kg * at[4] * at[4]) * at[1];
  };
  const VectorXd end = Simulate(plant, x, 1.5, 3000, [](double t, const VectorXd&) {
    return VectorXd(Eigen::Vector3d(0, 0, 20 * std::sin(3 * t)));
  });
  EXPECT_GT(std::abs(end[4] - x[4]), 0.1) << "the arm moved";
  EXPECT_NEAR(momentum(end), momentum(x), 1e-9);
}

/// A straight line across a turning column: x5 cos x1 = 0.4 m, at 0.5 m/s along it, while
/// the lift goes down by 0.2 m/s. Differentiated once: conditions on the speeds.
ProgramConditions LineProgram(const VectorXd& x, double return_per_s) {
  const double c = std::cos(x[0]), s = std::sin(x[0]);
  // Speeds across and along the line, and of the lift.
  VectorXd omega(3);
  omega << x[5] * c - x[4] * x[1] * s, x[5] * s + x[4] * x[1] * c - 0.5, x[3] + 0.2;
  ProgramConditions conditions;
  conditions.gradient = MatrixXd::Zero(3, 6);
  conditions.gradient.row(0) << -x[5] * s - x[4] * x[1] * c, -x[4] * s, 0, 0, -x[1] * s,
      c;
  conditions.gradient.row(1) << x[5] * c - x[4] * x[1] * s, x[4] * c, 0, 0, x[1] * c, s;
  conditions.gradient(2, 3) = 1;
  conditions.explicit_rate = VectorXd::Zero(3);
  conditions.return_rate = -return_per_s * omega;
  return conditions;
}

TEST(InverseDynamics, ItsControlsHoldALineAcrossTheTurningColumn) {
  const AffinePlant plant = PlantOf(kColumn);
  VectorXd x(6);
  x << 0, 0.5 / 0.4, 1, -0.2, 0.4, 0;  // on the line, at its speed
  const VectorXd end = Simulate(plant, x, 1, 2000, [&](double, const VectorXd& at) {
    return ControlsThatHold(plant, LineProgram(at, 0), at).value();
  });
  // After a second 0.5 m along the line, whatever angle and reach that takes.
  EXPECT_NEAR(end[4] * std::cos(end[0]), 0.4, 1e-9);
  EXPECT_NEAR(end[4] * std::sin(end[0]), 0.5, 1e-9);
  EXPECT_NEAR(end[2], 0.8, 1e-9);
}

TEST(InverseDynamics, TermsRLeadADisturbedMotionBack) {
  const AffinePlant plant = PlantOf(kColumn);
  VectorXd x(6);
  x << 0, 0.6 / 0.4, 1, 0.1, 0.4, 0.05;  // too fast, and across
  const VectorXd end = Simulate(plant, x, 1, 4000, [&](double, const VectorXd& at) {
    return ControlsThatHold(plant, LineProgram(at, 20), at).value();
  });
  const ProgramConditions left = LineProgram(end, -1);  // R is omega then
  const ProgramConditions first = LineProgram(x, -1);
  // exp(-20) of the disturbance is left.
  EXPECT_NEAR(left.return_rate.norm() / first.return_rate.norm(), std::exp(-20), 1e-11);
}

TEST(InverseDynamics, FreeControlsHaveTheMinimumEffort) {
  // One condition, two forces: 3 u1 + 4 u2 = 10. The nearest to 0 is (1.2, 1.6).
  AffinePlant plant;
  plant.drift = [](const VectorXd&) { return VectorXd::Zero(2); };
  plant.input = [](const VectorXd&) { return MatrixXd::Identity(2, 2); };
  ProgramConditions conditions;
  conditions.gradient = (MatrixXd(1, 2) << 3, 4).finished();
  conditions.explicit_rate = VectorXd::Constant(1, -10);
  conditions.return_rate = VectorXd::Zero(1);
  const auto u = ControlsThatHold(plant, conditions, VectorXd::Zero(2));
  ASSERT_TRUE(u.has_value());
  EXPECT_TRUE(u->isApprox(Eigen::Vector2d(1.2, 1.6), 1e-12)) << u->transpose();
}

TEST(InverseDynamics, AConditionOnPlacesAloneIsRefused) {
  const AffinePlant plant = PlantOf(kColumn);
  VectorXd x(6);
  x << 0, 0, 1, 0.3, 0.4, 0;
  ProgramConditions height;  // x3 = 1, not differentiated, while it rises
  height.gradient = MatrixXd::Zero(1, 6);
  height.gradient(0, 2) = 1;
  height.explicit_rate = height.return_rate = VectorXd::Zero(1);
  const auto none = ControlsThatHold(plant, height, x);
  ASSERT_FALSE(none.has_value());
  EXPECT_EQ(none.error().code, ErrorCode::kInvalidValue);
  height.return_rate = VectorXd::Zero(2);
  EXPECT_THROW((void)ControlsThatHold(plant, height, x), PreconditionError);
}

}  // namespace
}  // namespace intaglio::motion
