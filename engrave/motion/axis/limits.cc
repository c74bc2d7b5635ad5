#include "engrave/motion/axis/limits.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::motion {

void RequireUsable(const Limits& limits) {
  for (int axis = 0; axis < 3; ++axis) {
    const double speed = limits.max_speed_mm_s[axis];
    const double acceleration = limits.max_acceleration_mm_s2[axis];
    Require(speed > 0.0 && std::isfinite(speed),
            "max_speed_mm_s of axis {} must be positive and finite, is {}", axis, speed);
    Require(acceleration > 0.0 && std::isfinite(acceleration),
            "max_acceleration_mm_s2 of axis {} must be positive and finite, is {}", axis,
            acceleration);
    const double jerk = limits.max_jerk_mm_s3[axis];
    Require(jerk > 0.0, "max_jerk_mm_s3 of axis {} must be positive, is {}", axis, jerk);
  }
  Require(limits.max_speed_norm_mm_s > 0.0, "max_speed_norm_mm_s must be positive, is {}",
          limits.max_speed_norm_mm_s);
  Require(limits.max_acceleration_norm_mm_s2 > 0.0,
          "max_acceleration_norm_mm_s2 must be positive, is {}",
          limits.max_acceleration_norm_mm_s2);
  Require(!limits.travel_mm.empty(), "travel_mm is empty");
}

Limits LimitsAtSpeed(const Limits& limits, const Limits& ceiling, double ratio) {
  Require(ratio > 0.0, "the ratio of the speed must be positive, is {}", ratio);
  Limits result = limits;
  const double p = ratio;
  result.max_speed_mm_s *= p;
  result.max_speed_norm_mm_s *= p;
  result.max_acceleration_mm_s2 *= p * p;
  result.max_acceleration_norm_mm_s2 *= p * p;
  result.max_jerk_mm_s3 *= p * p * p;
  if (p <= 1) return result;
  result.max_speed_mm_s = result.max_speed_mm_s.cwiseMin(ceiling.max_speed_mm_s);
  result.max_speed_norm_mm_s =
      std::min(result.max_speed_norm_mm_s, ceiling.max_speed_norm_mm_s);
  result.max_acceleration_mm_s2 =
      result.max_acceleration_mm_s2.cwiseMin(ceiling.max_acceleration_mm_s2);
  result.max_acceleration_norm_mm_s2 =
      std::min(result.max_acceleration_norm_mm_s2, ceiling.max_acceleration_norm_mm_s2);
  result.max_jerk_mm_s3 = result.max_jerk_mm_s3.cwiseMin(ceiling.max_jerk_mm_s3);
  return result;
}

}  // namespace intaglio::motion
