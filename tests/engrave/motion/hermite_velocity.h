#pragma once

// The velocity on a segment (segment.h): the derivatives of the four Hermite weights,
// with u = t / duration,
//   h00' = 6u^2 - 6u = -h01',   h10' = 3u^2 - 4u + 1,   h11' = 3u^2 - 2u.
// The planners and the verifier have the powers of t or Bezier points instead.

#include "engrave/motion/segments/segment.h"

namespace intaglio::motion {

/// mm/s, `seconds` (0..duration_s) after the knot `from`; duration_s > 0.
inline Vec3 HermiteVelocity(const KnotState& from, const Segment& to, double seconds,
                            double duration_s) {
  const double u = seconds / duration_s;
  const Vec3 mean_mm_s = (to.end_position_mm - from.position_mm) / duration_s;
  return 6.0 * u * (1.0 - u) * mean_mm_s +
         (3.0 * u - 1.0) * (u - 1.0) * from.velocity_mm_s +
         u * (3.0 * u - 2.0) * to.end_velocity_mm_s;
}

}  // namespace intaglio::motion
