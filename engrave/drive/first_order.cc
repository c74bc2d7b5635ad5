#include "engrave/drive/first_order.h"

#include <cmath>

#include "engrave/core/check.h"

// For a cubic command c the particular solution of x + T x' = c is
//   q = c - T c' + T^2 c'' - T^3 c'''
// (insert it: q + T q' = c, as the fourth derivative is zero), here by its derivatives
// from the highest down, q^(k) = c^(k) - T q^(k+1). The rest decays: x = q + e exp(-t /
// T).
//
// Lead. Where the course brakes with A and has the distance s = v^2 / (2 A) left, the
// command is T v ahead, which is T v - v^2 / (2 A) beyond the place of rest: at most A
// T^2 / 2, at v = A T.

namespace intaglio::drive {

FirstOrder::FirstOrder(double lag_s) : lag_s_(lag_s) {
  Require(lag_s >= 0 && lag_s <= kMaxLagS, "lag_s {} is outside 0..{}", lag_s, kMaxLagS);
}

Cubic FirstOrder::Settled(const Cubic& command) const {
  Cubic q;
  q.jerk_u_s3 = command.jerk_u_s3;
  q.acceleration_u_s2 = command.acceleration_u_s2 - lag_s_ * q.jerk_u_s3;
  q.velocity_u_s = command.velocity_u_s - lag_s_ * q.acceleration_u_s2;
  q.position_u = command.position_u - lag_s_ * q.velocity_u_s;
  return q;
}

Cubic FirstOrder::CommandFor(const Cubic& course) const {
  return {course.position_u + lag_s_ * course.velocity_u_s,
          course.velocity_u_s + lag_s_ * course.acceleration_u_s2,
          course.acceleration_u_s2 + lag_s_ * course.jerk_u_s3, course.jerk_u_s3};
}

AxisState FirstOrder::SettledState(const Cubic& command) const {
  const Cubic q = Settled(command);
  return {q.position_u, q.velocity_u_s};
}

AxisState FirstOrder::Follow(const AxisState& state, const Cubic& command,
                             double duration_s) const {
  const Cubic q = Settled(command);
  if (lag_s_ <= 0) return {q.At(duration_s), q.VelocityAt(duration_s)};
  const double rest_u =
      (state.position_u - q.position_u) * std::exp(-duration_s / lag_s_);
  return {q.At(duration_s) + rest_u, q.VelocityAt(duration_s) - rest_u / lag_s_};
}

}  // namespace intaglio::drive
