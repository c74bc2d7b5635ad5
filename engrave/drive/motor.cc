#include "engrave/drive/motor.h"

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"

namespace intaglio::drive {
namespace {

double MetresPerRadian(double lead_m) { return lead_m / (2 * std::numbers::pi); }

/// R B + Kt Kv.
double Denominator(const Motor& m) {
  return m.resistance_ohm * m.friction_nm_s + m.torque_constant_nm_a * m.back_emf_v_s;
}

}  // namespace

VelocityLoop CloseVelocityLoop(const Motor& motor, const Amplifier& amplifier,
                               double inertia_kg_m2) {
  Require(motor.resistance_ohm > 0 && motor.torque_constant_nm_a > 0 &&
              motor.back_emf_v_s > 0 && motor.friction_nm_s >= 0 && inertia_kg_m2 > 0,
          "a motor of {} ohm, {} Nm/A, {} V s, {} Nm s and {} kg m^2",
          motor.resistance_ohm, motor.torque_constant_nm_a, motor.back_emf_v_s,
          motor.friction_nm_s, inertia_kg_m2);
  Require(amplifier.gain_v_v > 0 && amplifier.tachometer_v_s >= 0,
          "an amplifier of {} V/V with a tachometer of {} V s", amplifier.gain_v_v,
          amplifier.tachometer_v_s);
  const double den = Denominator(motor);
  const double forward = amplifier.gain_v_v * motor.torque_constant_nm_a / den;
  VelocityLoop loop;
  loop.alpha = 1 / (1 + forward * amplifier.tachometer_v_s);
  loop.motor_time_s = motor.resistance_ohm * inertia_kg_m2 / den;
  loop.time_s = loop.alpha * loop.motor_time_s;
  loop.gain_rad_v_s = loop.alpha * forward;
  return loop;
}

PositionLoop FromPanel(const PanelGains& gains, double feed_forward_ratio) {
  Require(gains.volt_per_step > 0, "volt_per_step {} must be positive",
          gains.volt_per_step);
  Require(gains.unit == PanelUnit::kVoltPerMm || gains.counts_per_m > 0,
          "counts_per_m {} must be positive", gains.counts_per_m);
  const double units_per_m =
      gains.unit == PanelUnit::kVoltPerMm ? 1000 : gains.counts_per_m;
  const double volt = gains.volt_per_step * units_per_m;
  return {gains.proportional * volt, gains.derivative_s * volt, feed_forward_ratio};
}

ServoLoop CloseAxis(const VelocityLoop& velocity, const PositionLoop& position,
                    double lead_m) {
  Require(lead_m > 0, "lead_m {} must be positive", lead_m);
  const double metres_v_s = velocity.gain_rad_v_s * MetresPerRadian(lead_m);
  return {position.volt_per_m * metres_v_s, velocity.time_s,
          position.volt_s_per_m * metres_v_s, position.feed_forward_ratio};
}

double LoadAcceleration(const Motor& motor, const VelocityLoop& velocity, double lead_m,
                        double torque_nm) {
  return torque_nm * motor.resistance_ohm * MetresPerRadian(lead_m) /
         (Denominator(motor) * velocity.motor_time_s);
}

double StaticError(const ServoLoop& axis, double load_acceleration) {
  return axis.velocity_time_s * load_acceleration / axis.position_gain_per_s;
}

double LagSeconds(const ServoLoop& axis) {
  return (1 - axis.feed_forward_ratio) / axis.position_gain_per_s;
}

double DampingRatio(const ServoLoop& axis) {
  return (1 + axis.derivative_ratio) /
         (2 * std::sqrt(axis.position_gain_per_s * axis.velocity_time_s));
}

}  // namespace intaglio::drive
