#include "engrave/drive/loop_kinds.h"

#include <numbers>

// Stepper: x (s^2 + G) = G u with G = q^2 + 2 d2 q s, so
//   u (s^2 + 2 d1 p s + p^2 + m G) = p^2 c + m G x,
// and with u = x (s^2 + G) / G, divided by p^2 q^2,
//   x [P Q + m s^2 / p^2 N] = N c,  N = G / q^2 = 1 + 2 d2 s / q,
// P and Q those of a spring each, 1 + 2 d s / w + s^2 / w^2.

namespace intaglio::drive {
namespace {

double RadPerSecond(double frequency_hz) { return 2 * std::numbers::pi * frequency_hz; }

Polynomial Spring(double frequency_hz, double damping_ratio) {
  const double w = RadPerSecond(frequency_hz);
  return {1, 2 * damping_ratio / w, 1 / (w * w)};
}

}  // namespace

Transfer TransferOf(const ServoLoop& servo) {
  const double gain = servo.position_gain_per_s, d = servo.derivative_ratio;
  return {{1, (d + servo.feed_forward_ratio) / gain},
          {1, (1 + d) / gain, servo.velocity_time_s / gain}};
}

Transfer TransferOf(const CascadeLoop& cascade) {
  const double w = cascade.position_gain_per_s;
  const Polynomial loops = {1, 1 / w, 1 / (3 * w * w), 1 / (36 * w * w * w)};
  return {{1},
          Product(loops, Spring(cascade.natural_frequency_hz, cascade.damping_ratio))};
}

Transfer TransferOf(const StepperScrewLoop& stepper) {
  const double p = RadPerSecond(stepper.rotor_frequency_hz);
  const double q = RadPerSecond(stepper.carriage_frequency_hz);
  const Polynomial screw = {1, 2 * stepper.carriage_damping_ratio / q};
  const Polynomial springs =
      Product(Spring(stepper.rotor_frequency_hz, stepper.rotor_damping_ratio),
              Spring(stepper.carriage_frequency_hz, stepper.carriage_damping_ratio));
  return {screw, Sum(springs, Product({0, 0, stepper.inertia_ratio / (p * p)}, screw))};
}

PidGains GainsOf(const PlanarLoop& planar) {
  const double w = RadPerSecond(planar.natural_frequency_hz);
  const double damping_per_s = 2 * planar.damping_ratio * w;
  const double rate = planar.integral_rate_per_s;
  return {w * w + damping_per_s * rate, w * w * rate, damping_per_s + rate};
}

Transfer TransferOf(const PlanarLoop& planar) {
  const PidGains pid = GainsOf(planar);
  const double kp = pid.proportional_per_s2 / pid.integral_per_s3;
  const double kd = pid.derivative_per_s / pid.integral_per_s3;
  return {{1, kp, kd}, {1, kp, kd, 1 / pid.integral_per_s3}};
}

}  // namespace intaglio::drive
