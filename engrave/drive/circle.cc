#include "engrave/drive/circle.h"

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"

namespace intaglio::drive {

CircularInterpolator::CircularInterpolator(double radius, double speed, double period_s,
                                           RotationRule rule)
    : at_(radius, 0) {
  Require(radius > 0 && speed > 0 && period_s > 0,
          "a circle of {} with speed {} and a period of {} s", radius, speed, period_s);
  const double steps = std::round(2 * std::numbers::pi * radius / (speed * period_s));
  Require(steps >= 3 && steps < 1e9, "{} steps a turn are not in 3..1e9", steps);
  steps_ = static_cast<int>(steps);
  const double angle = 2 * std::numbers::pi / steps, quarter = angle * angle / 4;
  switch (rule) {
    case RotationRule::kExact:
      a_ = std::cos(angle), b_ = std::sin(angle);
      break;
    case RotationRule::kTustin:
      a_ = (1 - quarter) / (1 + quarter), b_ = angle / (1 + quarter);
      break;
    case RotationRule::kEuler:
      a_ = 1, b_ = angle;
      break;
  }
}

Vec2 CircularInterpolator::Next() {
  at_ = Vec2(a_ * at_.x() - b_ * at_.y(), a_ * at_.y() + b_ * at_.x());
  return at_;
}

}  // namespace intaglio::drive
