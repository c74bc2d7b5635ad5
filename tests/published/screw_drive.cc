#include "tests/published/screw_drive.h"

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"

// (114) multiplied by n_t is the equation at the motor's shaft, with the twist of the
// spring T = n_t w - v / n_v2 and the torque in the shaft M = M_k + B3 T:
//   (theta_1 + n_t^2 theta_2) w' = i / n_v1 - (B1 + n_t^2 B2) w - n_t M,
//   m v' = M / n_v2 - (B4 / n_v2^2 + b_x) v,   M_k' = K T.
// A stepper's field holds its rotor with holding torque times teeth, Nm/rad, at the
// motor; the table seen from the motor has the inertia m (n_t n_v2)^2.

namespace intaglio::drive {
namespace {

double RotorInertia(const ScrewDrive& d) {
  return d.rotor_inertia_kg_m2 + d.gear_ratio * d.gear_ratio * d.screw_inertia_kg_m2;
}

double TableInertia(const ScrewDrive& d) {
  const double metres = d.gear_ratio * d.metres_rad;
  return d.table_mass_kg * metres * metres;
}

double TwistRate(const ScrewDrive& d, const ScrewDriveState& s) {
  return d.gear_ratio * s.motor_rad_s - s.table_m_s / d.metres_rad;
}

void Check(const ScrewDrive& d) {
  Require(d.rad_v_s > 0 && d.gear_ratio > 0 && d.metres_rad > 0 &&
              d.stiffness_nm_rad > 0 && d.rotor_inertia_kg_m2 > 0 && d.table_mass_kg > 0,
          "a screw drive of {} rad/Vs, gear {}, {} m/rad, {} Nm/rad, {} kg m^2, {} kg",
          d.rad_v_s, d.gear_ratio, d.metres_rad, d.stiffness_nm_rad,
          d.rotor_inertia_kg_m2, d.table_mass_kg);
}

}  // namespace

ScrewDriveState SlopeOf(const ScrewDrive& d, const ScrewDriveState& s, double volt) {
  Check(d);
  Require(d.inductance_h > 0, "inductance_h {} must be positive", d.inductance_h);
  const double twist = TwistRate(d, s);
  const double torque_nm = s.shaft_torque_nm + d.shaft_damping_nm_s * twist;
  const double gear2 = d.gear_ratio * d.gear_ratio;
  ScrewDriveState slope;
  slope.motor_rad_s =
      (s.current_a / d.rad_v_s -
       (d.motor_bearing_nm_s + gear2 * d.gear_bearing_nm_s) * s.motor_rad_s -
       d.gear_ratio * torque_nm) /
      RotorInertia(d);
  slope.table_m_s =
      (torque_nm / d.metres_rad -
       (d.screw_bearing_nm_s / (d.metres_rad * d.metres_rad) + d.guide_n_s_m) *
           s.table_m_s) /
      d.table_mass_kg;
  slope.shaft_torque_nm = d.stiffness_nm_rad * twist;
  slope.current_a = (volt - d.resistance_ohm * s.current_a - s.motor_rad_s / d.rad_v_s) /
                    d.inductance_h;
  return slope;
}

double EnergyOf(const ScrewDrive& d, const ScrewDriveState& s) {
  return 0.5 * (d.inductance_h * s.current_a * s.current_a +
                RotorInertia(d) * s.motor_rad_s * s.motor_rad_s +
                d.table_mass_kg * s.table_m_s * s.table_m_s +
                s.shaft_torque_nm * s.shaft_torque_nm / d.stiffness_nm_rad);
}

double LossOf(const ScrewDrive& d, const ScrewDriveState& s) {
  const double behind_gear = d.gear_ratio * s.motor_rad_s;
  const double screw = s.table_m_s / d.metres_rad, twist = TwistRate(d, s);
  return d.resistance_ohm * s.current_a * s.current_a +
         d.motor_bearing_nm_s * s.motor_rad_s * s.motor_rad_s +
         d.gear_bearing_nm_s * behind_gear * behind_gear +
         d.shaft_damping_nm_s * twist * twist + d.screw_bearing_nm_s * screw * screw +
         d.guide_n_s_m * s.table_m_s * s.table_m_s;
}

StepperScrewLoop LoopOf(const ScrewDrive& d, const StepperMotor& stepper) {
  Check(d);
  Require(stepper.holding_torque_nm > 0 && stepper.rotor_teeth > 0 &&
              stepper.damping_nm_s > 0,
          "a stepper of {} Nm, {} teeth and {} Nm s", stepper.holding_torque_nm,
          stepper.rotor_teeth, stepper.damping_nm_s);
  Require(d.screw_bearing_nm_s == 0 && d.guide_n_s_m == 0,
          "the table is damped to the ground by {} Nm s and {} N s/m",
          d.screw_bearing_nm_s, d.guide_n_s_m);
  const double rotor = RotorInertia(d), table = TableInertia(d);
  const double gear2 = d.gear_ratio * d.gear_ratio;
  const double field = stepper.holding_torque_nm * stepper.rotor_teeth;
  const double shaft = gear2 * d.stiffness_nm_rad;
  const double losses =
      stepper.damping_nm_s + d.motor_bearing_nm_s + gear2 * d.gear_bearing_nm_s;
  const double p = std::sqrt(field / rotor), q = std::sqrt(shaft / table);
  return {p / (2 * std::numbers::pi), losses / (2 * p * rotor),
          q / (2 * std::numbers::pi), gear2 * d.shaft_damping_nm_s / (2 * q * table),
          table / rotor};
}

double LargestAcceleration(const ScrewDrive& d, const StepperMotor& stepper) {
  Check(d);
  return stepper.holding_torque_nm / (RotorInertia(d) + TableInertia(d)) * d.gear_ratio *
         d.metres_rad;
}

}  // namespace intaglio::drive
