#pragma once

// Setpoints on a circle, each from the one before by one rotation (Tirnovean 2016,
// (4.43)-(4.58); (4.46) is y' = A y + B x, (4.58) is l = F Ts, both corrected).

#include "engrave/core/geometry.h"

namespace intaglio::drive {

/// A and B of x' = A x - B y, y' = A y + B x, for the angle a of a step.
enum class RotationRule {
  kExact,   ///< cos a, sin a: the radius stays
  kTustin,  ///< (1 - a^2/4) / (1 + a^2/4), a / (1 + a^2/4): the radius stays, a little
            ///< slow
  kEuler,   ///< 1, a: the radius grows by a factor sqrt(1 + a^2) a step
};

class CircularInterpolator {
 public:
  /// Counterclockwise from (radius, 0) about the origin, a whole number of steps a turn:
  /// that which is nearest to `speed` times `period_s` along the circle. All > 0, one
  /// unit of length. Throws PreconditionError, also for less than three steps a turn.
  CircularInterpolator(double radius, double speed, double period_s, RotationRule rule);

  int steps_per_turn() const { return steps_; }
  /// The next setpoint.
  Vec2 Next();
  const Vec2& at() const { return at_; }

 private:
  int steps_;
  double a_, b_;
  Vec2 at_;
};

}  // namespace intaglio::drive
