#include "engrave/drive/second_order.h"

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"

// With l1 = 2 d / w and l2 = 1 / w^2 the equation is x + l1 x' + l2 x'' = c. For a cubic
// command the particular solution q is, from its highest derivative down,
//   q^(k) = c^(k) - l1 q^(k+1) - l2 q^(k+2).
// The rest e = x - q obeys e'' + 2 d w e' + w^2 e = 0 and is, from e0 and e0',
//   e  = exp(-d w t) (e0 C + (e0' + d w e0) S)
//   e' = exp(-d w t) (e0' C - (w^2 e0 + d w e0') S)
// with r = w sqrt |1 - d^2| and C = cos(r t), S = sin(r t) / r below d = 1, cosh and sinh
// above it, 1 and t at it. The exponentials are multiplied before they overflow.
//
// Lead. As for the first order, with l2 A more where the course still accelerates
// towards the place of rest: l1 v + l2 A - v^2 / (2 A) is at most A (l1^2 / 2 + l2).

namespace intaglio::drive {
namespace {

/// exp(-d w t) times C and times S.
struct Fade {
  double cosine = 1, sine_s = 0;
};

// Below it sin(y) / y is 1 - y^2 / 6 to the last bit.
constexpr double kSmallAngle = 1e-4;

Fade FadeOf(double w, double d, double t_s) {
  const double rate_s = w * std::sqrt(std::abs(1 - d * d));
  const double angle = rate_s * t_s;
  const double decay = std::exp(-d * w * t_s);
  const double sign = d < 1 ? -1 : 1;
  if (angle < kSmallAngle) {
    return {decay * (1 + sign * angle * angle / 2),
            decay * t_s * (1 + sign * angle * angle / 6)};
  }
  if (d < 1) return {decay * std::cos(angle), decay * std::sin(angle) / rate_s};
  const double slow = std::exp((rate_s - d * w) * t_s);
  const double fast = std::exp((-rate_s - d * w) * t_s);
  return {(slow + fast) / 2, (slow - fast) / (2 * rate_s)};
}

}  // namespace

SecondOrder::SecondOrder(double natural_frequency_hz, double damping_ratio)
    : natural_rad_s_(2 * std::numbers::pi * natural_frequency_hz),
      damping_ratio_(damping_ratio),
      velocity_lag_s_(2 * damping_ratio / natural_rad_s_),
      acceleration_lag_s2_(1 / (natural_rad_s_ * natural_rad_s_)) {
  Require(natural_frequency_hz >= kMinNaturalFrequencyHz &&
              natural_frequency_hz <= kMaxNaturalFrequencyHz,
          "natural_frequency_hz {} is outside {}..{}", natural_frequency_hz,
          kMinNaturalFrequencyHz, kMaxNaturalFrequencyHz);
  Require(damping_ratio >= kMinDampingRatio && damping_ratio <= kMaxDampingRatio,
          "damping_ratio {} is outside {}..{}", damping_ratio, kMinDampingRatio,
          kMaxDampingRatio);
}

double SecondOrder::lead_s2() const {
  return 0.5 * velocity_lag_s_ * velocity_lag_s_ + acceleration_lag_s2_;
}

Cubic SecondOrder::Settled(const Cubic& command) const {
  Cubic q;
  q.jerk_u_s3 = command.jerk_u_s3;
  q.acceleration_u_s2 = command.acceleration_u_s2 - velocity_lag_s_ * q.jerk_u_s3;
  q.velocity_u_s = command.velocity_u_s - velocity_lag_s_ * q.acceleration_u_s2 -
                   acceleration_lag_s2_ * q.jerk_u_s3;
  q.position_u = command.position_u - velocity_lag_s_ * q.velocity_u_s -
                 acceleration_lag_s2_ * q.acceleration_u_s2;
  return q;
}

Cubic SecondOrder::CommandFor(const Cubic& course) const {
  return {course.position_u + velocity_lag_s_ * course.velocity_u_s +
              acceleration_lag_s2_ * course.acceleration_u_s2,
          course.velocity_u_s + velocity_lag_s_ * course.acceleration_u_s2 +
              acceleration_lag_s2_ * course.jerk_u_s3,
          course.acceleration_u_s2 + velocity_lag_s_ * course.jerk_u_s3,
          course.jerk_u_s3};
}

AxisState SecondOrder::SettledState(const Cubic& command) const {
  const Cubic q = Settled(command);
  return {q.position_u, q.velocity_u_s};
}

AxisState SecondOrder::Follow(const AxisState& state, const Cubic& command,
                              double duration_s) const {
  const Cubic q = Settled(command);
  const double w = natural_rad_s_, d = damping_ratio_;
  const double e_u = state.position_u - q.position_u;
  const double e_u_s = state.velocity_u_s - q.velocity_u_s;
  const Fade fade = FadeOf(w, d, duration_s);
  return {q.At(duration_s) + fade.cosine * e_u + fade.sine_s * (e_u_s + d * w * e_u),
          q.VelocityAt(duration_s) + fade.cosine * e_u_s -
              fade.sine_s * (w * w * e_u + d * w * e_u_s)};
}

}  // namespace intaglio::drive
