#include "engrave/drive/loop_kinds.h"

#include <numbers>

// Stepper: x (s^2 + G) = G u with G = q^2 + 2 d2 q s, so
//   u (s^2 + 2 d1 p s + p^2 + m G) = p^2 c + m G x,
// and with u = x (s^2 + G) / G, divided by p^2 q^2,
//   x [P Q + m s^2 / p^2 N] = N c,  N = G / q^2 = 1 + 2 d2 s / q,
// P and Q those of a spring each, 1 + 2 d s / w + s^2 / w^2.
//
// Planar: with the period T the acceleration is held, 1 / H with H = 1 + s T / 2, and the
// difference of two samples is as late, kd s / H; the sum of samples is ki (1 / s + T/2):
//   s^2 x H = (kp + ki T / 2 + ki / s + kd s / H) (c - x),
// times s H: s^3 H^2 x = N (c - x), N = ki + (kp + ki T) s + (kd + kp T/2 + ki T^2/4)
// s^2. The lags of first order are those of e^(-s T / 2) within (w T)^2 / 8.

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
  const double ki = pid.integral_per_s3, t = planar.period_s;
  const double n1 = pid.proportional_per_s2 / ki + t;
  const double n2 =
      (pid.derivative_per_s + pid.proportional_per_s2 * t / 2) / ki + t * t / 4;
  return {{1, n1, n2}, {1, n1, n2, 1 / ki, t / ki, t * t / (4 * ki)}};
}

namespace {

/// Whether the sampled loop is stable: its roots in z lie within the unit circle, so
/// those in w, z = (1 + w) / (1 - w), left of the imaginary axis.
bool IsStableSampled(const PidGains& pid, double period_s) {
  const double t = period_s;
  const double q0 =
      pid.integral_per_s3 * t + pid.proportional_per_s2 + pid.derivative_per_s / t;
  const double q1 = -(pid.proportional_per_s2 + 2 * pid.derivative_per_s / t);
  const double q2 = pid.derivative_per_s / t, plant = t * t / 2;
  const Polynomial in_z = {plant * q2, -1 + plant * (q1 + q2), 3 + plant * (q0 + q1),
                           -3 + plant * q0, 1};
  constexpr std::size_t kOrder = 4;
  Polynomial in_w = {};
  for (std::size_t k = 0; k <= kOrder; ++k) {
    Polynomial term = {in_z[k]};
    for (std::size_t i = 0; i < kOrder; ++i)
      term = Product(term, i < k ? Polynomial{1, 1} : Polynomial{1, -1});
    in_w = Sum(in_w, term);
  }
  return IsStable(in_w);
}

}  // namespace

double LongestPeriodS(const PlanarLoop& planar) {
  const PidGains pid = GainsOf(planar);
  double low_s = 0, high_s = 1 / pid.derivative_per_s;
  while (IsStableSampled(pid, high_s)) high_s *= 2;
  for (int i = 0; i < 50; ++i) {
    const double middle_s = (low_s + high_s) / 2;
    (IsStableSampled(pid, middle_s) ? low_s : high_s) = middle_s;
  }
  return low_s;
}

}  // namespace intaglio::drive
