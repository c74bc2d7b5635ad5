#pragma once

// The fastest swing at one corner (swing.h). For a speed at the corner a linear program
// finds the knots whose greatest load, a ratio to its limit, is the least; the speed is
// the greatest up to the feed with a load of 1. Limits, at each setpoint: the load within
// the tolerance of the leg before the corner until the corner's instant and of the leg
// behind it from then on, at that instant within the tolerance of the corner, and each
// axis' motor within its acceleration and its load within its jerk. All of them are
// linear but the circle around the corner, of which a polygon inside it is used. The law
// along the path slows down to the corner and speeds up behind it by a constant
// acceleration, up to the feed.

#include <optional>

#include "engrave/course/correction.h"
#include "engrave/course/swing.h"

namespace intaglio::course {

class SwingMaker {
 public:
  /// `tracking` is compensated, `allowed` has a limit of the motors, and outlives this.
  SwingMaker(const Tracking& tracking, const Allowed& allowed, double acceleration_mm_s2)
      : tracking_(tracking), allowed_(allowed), acceleration_mm_s2_(acceleration_mm_s2) {}

  struct Corner {
    Vec2 before, behind;  ///< directions of unit length
    double feed_mm_s = 0;
    double half_s = 0;  ///< how long the swing may be on each side
  };
  /// None when no speed keeps the limits.
  std::optional<SwingShape> Make(const Corner& corner) const;

 private:
  const Tracking& tracking_;
  Allowed allowed_;
  double acceleration_mm_s2_;
};

}  // namespace intaglio::course
