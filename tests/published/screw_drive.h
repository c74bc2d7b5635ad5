#pragma once

// A motor that turns a screw over a gear and an elastic shaft (Trochimczuk 2008, ch. 8.1,
// (109)-(115)): four states, from the voltage to the speed of the table. SI units.

#include "engrave/drive/loop_kinds.h"

namespace intaglio::drive {

struct ScrewDrive {
  double inductance_h = 0;    ///< L, > 0
  double resistance_ohm = 0;  ///< R, >= 0
  double rad_v_s = 0;     ///< n_v1, > 0: speed of the motor per volt; 1 / it is Nm per A
  double gear_ratio = 1;  ///< n_t, > 0: speed behind the gear over the motor's
  double metres_rad = 0;  ///< n_v2, > 0: of the screw
  double stiffness_nm_rad = 0;     ///< K, > 0, of the shaft
  double rotor_inertia_kg_m2 = 0;  ///< theta_1, > 0
  double screw_inertia_kg_m2 = 0;  ///< theta_2, >= 0
  double table_mass_kg = 0;        ///< m_x, > 0
  double motor_bearing_nm_s = 0;   ///< B1, >= 0
  double gear_bearing_nm_s = 0;    ///< B2, >= 0
  double shaft_damping_nm_s = 0;   ///< B3, >= 0, beside the shaft's spring
  double screw_bearing_nm_s = 0;   ///< B4, >= 0
  double guide_n_s_m = 0;          ///< b_x, >= 0
};

/// (115).
struct ScrewDriveState {
  double motor_rad_s = 0;      ///< w_4g
  double table_m_s = 0;        ///< w_7g
  double shaft_torque_nm = 0;  ///< M_k
  double current_a = 0;        ///< i
};

/// Its change in a second, (109), (113), (114).
ScrewDriveState SlopeOf(const ScrewDrive& drive, const ScrewDriveState& state,
                        double volt);
/// Stored: in coil, rotor, screw, table and shaft, J.
double EnergyOf(const ScrewDrive& drive, const ScrewDriveState& state);
/// Turned into heat: in coil, bearings, shaft and guide, W.
double LossOf(const ScrewDrive& drive, const ScrewDriveState& state);

/// A stepper in place of the motor: what holds its rotor and what damps it.
struct StepperMotor {
  double holding_torque_nm = 0;  ///< > 0
  double rotor_teeth = 50;       ///< > 0; 50 make 200 full steps a turn
  double damping_nm_s = 0;       ///< > 0
};
/// The parts of (109)-(115) as the drive of a profile (loop_kinds.h): rotor and screw on
/// the field, the table on the shaft. What damps the table to the ground, B4 and b_x, has
/// to be 0 there. Throws PreconditionError.
StepperScrewLoop LoopOf(const ScrewDrive& drive, const StepperMotor& stepper);
/// The largest acceleration that the field gives to all that moves, m/s^2: beyond it the
/// rotor loses steps.
double LargestAcceleration(const ScrewDrive& drive, const StepperMotor& stepper);

}  // namespace intaglio::drive
