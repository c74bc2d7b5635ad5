#pragma once

// Which way sections lie and rays run: an axis of the glass frame, turned.

#include "engrave/core/geometry.h"

namespace intaglio::discretize {

enum class Axis { kX, kY, kZ };

struct Direction {
  Axis axis = Axis::kZ;
  /// Angles about the fixed axes x, then y, then z, -pi..pi (alpha, beta, gamma of
  /// Trochimczuk 2008 annex A).
  Vec3 rotation_rad = Vec3::Zero();
};

/// Columns u, v, w: right-handed and orthonormal; w is the direction.
Mat3 FrameOf(const Direction& direction);

}  // namespace intaglio::discretize
