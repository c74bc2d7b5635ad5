#pragma once

// A DC servo motor that turns a screw, its amplifier with a tachometer loop, and what of
// it closes to a velocity loop (Tirnovean 2016, ch. 3 and 4). SI units throughout.

#include "engrave/drive/loop_kinds.h"

namespace intaglio::drive {

struct Motor {
  double resistance_ohm = 0;        ///< R, > 0, of the armature
  double torque_constant_nm_a = 0;  ///< Kt, > 0
  double back_emf_v_s = 0;          ///< Kv, > 0, V per rad/s
  double friction_nm_s = 0;         ///< B, >= 0, viscous
  double inertia_kg_m2 = 0;         ///< J, > 0, of the rotor
  double rated_torque_nm = 0;       ///< > 0, continuous
  double peak_current_a = 0;        ///< > 0
};

struct Amplifier {
  double gain_v_v = 0;        ///< Ka, > 0
  double tachometer_v_s = 0;  ///< Kth, >= 0, V per rad/s
  double max_control_v = 0;   ///< Umax, > 0, of the controller's output
};

/// tau w' + w = K1 U of the motor's speed w and the controller's voltage U; (3.10)-(3.15)
/// and (3.12).
struct VelocityLoop {
  double alpha = 0;         ///< what the tachometer leaves of the motor's time
  double motor_time_s = 0;  ///< tau_m = R J / (R B + Kt Kv)
  double time_s = 0;        ///< tau = alpha tau_m
  double gain_rad_v_s = 0;  ///< K1
};
/// `inertia_kg_m2` of all that turns, at the motor, > 0. Throws PreconditionError when a
/// value is outside the ranges above.
VelocityLoop CloseVelocityLoop(const Motor& motor, const Amplifier& amplifier,
                               double inertia_kg_m2);

/// What a number on the panel of a controller is counted in. There is no default: the
/// source defines its gains in V per mm and computes with encoder pulses, 250 times as
/// much.
enum class PanelUnit { kVoltPerMm, kEncoderPulse };

/// Gains as they are set. (3.19), (3.20), (4.36).
struct PanelGains {
  double proportional = 0;  ///< Kp, >= 0
  double derivative_s = 0;  ///< Kd, >= 0, of the rate of change of the unit
  PanelUnit unit;
  double volt_per_step = 0;  ///< Kc, > 0, of the converter: Umax / 2^(bits - 1)
  double counts_per_m = 0;   ///< > 0, encoder pulses; used with kEncoderPulse
};

/// The controller of the position: U = volt_per_m e + volt_s_per_m e' + the feed-forward,
/// e the commanded minus the measured position.
struct PositionLoop {
  double volt_per_m = 0;          ///< > 0
  double volt_s_per_m = 0;        ///< >= 0
  double feed_forward_ratio = 0;  ///< phi; 1 cancels the lag: 1 / (K1 Kg) V per m/s
};
PositionLoop FromPanel(const PanelGains& gains, double feed_forward_ratio);

/// The whole axis (loop_kinds.h): K = volt_per_m K1 Kg, D = volt_s_per_m K1 Kg, with Kg =
/// lead / (2 pi) (corrected from (3.18), (4.10), (4.17)). `lead_m` of the screw, > 0.
ServoLoop CloseAxis(const VelocityLoop& velocity, const PositionLoop& position,
                    double lead_m);

/// What a constant torque at the motor takes of the acceleration of the axis, m/s^2: a =
/// M R Kg / ((R B + Kt Kv) tau_m).
double LoadAcceleration(const Motor& motor, const VelocityLoop& velocity, double lead_m,
                        double torque_nm);

// Closed forms of an axis.
/// Position error under a constant load, in the unit of length of the acceleration.
double StaticError(const ServoLoop& axis, double load_acceleration);
/// Lag at constant speed, s: (1 - phi) / K.
double LagSeconds(const ServoLoop& axis);
/// zeta = (1 + D) / (2 sqrt(K tau)).
double DampingRatio(const ServoLoop& axis);

}  // namespace intaglio::drive
