#include "tests/published/inverse_dynamics.h"

#include <fmt/format.h>

#include <Eigen/QR>

#include "engrave/core/check.h"

namespace intaglio::motion {
namespace {

// Less of the right side that is left is rounding of a decomposition of a few rows.
constexpr double kUnsolvedRatio = 1e-9;

}  // namespace

Result<Eigen::VectorXd> ControlsThatHold(const AffinePlant& plant,
                                         const ProgramConditions& conditions,
                                         const Eigen::VectorXd& state) {
  const Eigen::MatrixXd& gradient = conditions.gradient;
  Require(gradient.cols() == state.size() &&
              gradient.rows() == conditions.explicit_rate.size() &&
              gradient.rows() == conditions.return_rate.size(),
          "{} conditions of {} states, with {} and {} rates, do not fit {} states",
          gradient.rows(), gradient.cols(), conditions.explicit_rate.size(),
          conditions.return_rate.size(), state.size());
  const Eigen::MatrixXd matrix = gradient * plant.input(state);
  const Eigen::VectorXd right =
      conditions.return_rate - conditions.explicit_rate - gradient * plant.drift(state);
  const Eigen::VectorXd controls = matrix.completeOrthogonalDecomposition().solve(right);
  const double unsolved = (matrix * controls - right).norm();
  if (unsolved > kUnsolvedRatio * (1 + right.norm())) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("no controls hold the program at this state: a rate of {} is "
                            "left; differentiate conditions on places once more, or "
                            "start on the program",
                            unsolved),
                fmt::format("{}", unsolved));
  }
  return controls;
}

AffinePlant PlantOf(const ColumnRobot& robot) {
  Require(robot.inertia_kg_m2 > 0 && robot.lift_mass_kg > 0 && robot.arm_mass_kg > 0,
          "inertia {} kg m^2 and masses {} and {} kg must be positive",
          robot.inertia_kg_m2, robot.lift_mass_kg, robot.arm_mass_kg);
  const auto turned = [robot](const Eigen::VectorXd& x) {
    return robot.inertia_kg_m2 + robot.arm_mass_kg * x[4] * x[4];
  };
  const double lifted_kg = robot.lift_mass_kg + robot.arm_mass_kg;
  AffinePlant plant;
  plant.drift = [=](const Eigen::VectorXd& x) {
    Eigen::VectorXd rate(6);
    rate << x[1],
        (-robot.turn_friction_n_m_s * x[1] - 2 * robot.arm_mass_kg * x[4] * x[5] * x[1]) /
            turned(x),
        x[3], -robot.lift_friction_n_s_m * x[3] / lifted_kg, x[5],
        -robot.arm_friction_n_s_m * x[5] / robot.arm_mass_kg + x[4] * x[1] * x[1];
    return rate;
  };
  plant.input = [=](const Eigen::VectorXd& x) {
    Eigen::MatrixXd input = Eigen::MatrixXd::Zero(6, 3);
    input(1, 0) = 1 / turned(x);
    input(3, 1) = 1 / lifted_kg;
    input(5, 2) = 1 / robot.arm_mass_kg;
    return input;
  };
  return plant;
}

double KineticEnergyJ(const ColumnRobot& robot, const Eigen::VectorXd& state) {
  const double turn = state[1], lift = state[3], reach = state[4], arm = state[5];
  return 0.5 * (robot.inertia_kg_m2 + robot.arm_mass_kg * reach * reach) * turn * turn +
         0.5 * (robot.lift_mass_kg + robot.arm_mass_kg) * lift * lift +
         0.5 * robot.arm_mass_kg * arm * arm;
}

}  // namespace intaglio::motion
