#pragma once

// What the stage may do, frame machine. Each axis has its own drive, so the limits
// are per axis: a move is held back by whichever axis is at its limit.

#include "engrave/core/geometry.h"

namespace intaglio::motion {

/// Limits of the three axes. All components > 0 and finite.
struct Limits {
  Vec3 max_speed_mm_s = Vec3::Constant(80.0);            ///< ELS-03 as published.
  Vec3 max_acceleration_mm_s2 = Vec3::Constant(7000.0);  ///< Above 7500 it shakes.
};

/// Throws PreconditionError unless every limit is positive and finite.
void RequireUsable(const Limits& limits);

}  // namespace intaglio::motion
