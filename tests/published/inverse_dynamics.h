#pragma once

// The controls that hold a program of motion, Trochimczuk 2008 ch. 6.2.2 (21)-(32), and
// the published plant with a rotary axis, ch. 6.2.3 (33)-(36). SI units; controllers of
// stages take positions, so these are for design and for checks of a program's forces.
//
// A plant is affine in its controls (27), (28): x' = p(x) + B(x) u. A program is a set of
// r conditions omega(t, x) = 0 (29). Along it d omega / dt = R(t, x, omega) with
// R(t, x, 0) = 0 (30)-(32), that is
//   G B u = R - omega_t - G p,   G = d omega / d x (r x n).
// Fewer conditions than controls leave some free: then the controls of minimum |u|^2, the
// integrand of (26), are taken. A condition on places has to be differentiated once, as
// in (39), so that a control occurs in its rate.

#include <Eigen/Core>
#include <functional>

#include "engrave/core/result.h"

namespace intaglio::motion {

/// x' = drift(x) + input(x) u; n states, any number of controls.
struct AffinePlant {
  std::function<Eigen::VectorXd(const Eigen::VectorXd& state)> drift;  ///< p, n
  std::function<Eigen::MatrixXd(const Eigen::VectorXd& state)>
      input;  ///< B, n x controls

  Eigen::VectorXd Rate(const Eigen::VectorXd& state,
                       const Eigen::VectorXd& controls) const {
    return drift(state) + input(state) * controls;
  }
};

/// A program at one instant and state.
struct ProgramConditions {
  Eigen::MatrixXd gradient;       ///< G, r x n
  Eigen::VectorXd explicit_rate;  ///< d omega / dt at a fixed state, r
  /// R, r: zero, or what leads a disturbed motion back, as -omega / tau.
  Eigen::VectorXd return_rate;
};

/// The controls of minimum |u| that hold the conditions (32). kInvalidValue when no
/// control does. Broken preconditions: sizes that do not fit.
Result<Eigen::VectorXd> ControlsThatHold(const AffinePlant& plant,
                                         const ProgramConditions& conditions,
                                         const Eigen::VectorXd& state);

/// The published three-axis positioner: a turning column, a lift on it and an arm that
/// extends from it. States (35): angle, its rate, height, its rate, reach, its rate;
/// controls: torque, two forces. Inertia J_z = J1 + J2 + J3 + m2 h2^2 > 0, masses > 0,
/// viscous frictions >= 0.
struct ColumnRobot {
  double inertia_kg_m2 = 1;
  double lift_mass_kg = 1;  ///< m2
  double arm_mass_kg = 1;   ///< m3
  double turn_friction_n_m_s = 0;
  double lift_friction_n_s_m = 0;
  double arm_friction_n_s_m = 0;
};

/// (36), corrected by Lagrange's equations of (33): the Coriolis term is
/// 2 m3 x5 x6 x2 (printed without x2), the lifted mass m2 + m3 (printed m4 + m3), and the
/// friction of the turn brakes (printed + b1 in (34)).
AffinePlant PlantOf(const ColumnRobot& robot);

/// (33), J: the kinetic energy of a state.
double KineticEnergyJ(const ColumnRobot& robot, const Eigen::VectorXd& state);

}  // namespace intaglio::motion
