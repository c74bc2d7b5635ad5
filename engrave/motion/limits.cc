#include "engrave/motion/limits.h"

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
  }
}

}  // namespace intaglio::motion
