#pragma once

// The axis of Tirnovean 2016, ch. 4 and 5: its motor, its amplifier, its controller.

#include "engrave/drive/sizing.h"

namespace intaglio::drive {

inline const Motor kSourceMotor = {.resistance_ohm = 0.18,
                                   .torque_constant_nm_a = 0.6,
                                   .back_emf_v_s = 0.2,
                                   .friction_nm_s = 0.75e-4,
                                   .inertia_kg_m2 = 0.26e-2,
                                   .rated_torque_nm = 6,
                                   .peak_current_a = 132};

inline const ScrewAxis kSourceAxis = {.mass_kg = 400,
                                      .lead_m = 0.01,
                                      .friction_ratio = 0.01,
                                      .efficiency_ratio = 0.9,
                                      .preload_torque_nm = 0.5,
                                      .screw_diameter_m = 0.025,
                                      .screw_length_m = 2.5,
                                      .coupling_inertia_kg_m2 = 200e-6};

inline constexpr double kSourceVoltPerStep = 0.00030518;
inline constexpr double kSourceCountsPerM = 250000;

inline const Amplifier kSourceAmplifier = {8.557, 0.007, 10};

/// The velocity loop with the printed time of the rotor, .004 s; R J / (R B + Kt Kv) is
/// .0039 s.
inline VelocityLoop SourceVelocity() {
  VelocityLoop loop =
      CloseVelocityLoop(kSourceMotor, kSourceAmplifier, kSourceMotor.inertia_kg_m2);
  loop.motor_time_s = 0.004;
  loop.time_s = loop.alpha * loop.motor_time_s;
  return loop;
}

inline PositionLoop SourceLoop(double kp, double kd, PanelUnit unit) {
  return FromPanel({kp, kd, unit, kSourceVoltPerStep, kSourceCountsPerM}, 0);
}

inline ServoLoop SourceServo(double kp, double kd, PanelUnit unit) {
  return CloseAxis(SourceVelocity(), SourceLoop(kp, kd, unit), kSourceAxis.lead_m);
}

}  // namespace intaglio::drive
