#include "engrave/motion/segments/segment.h"

#include <algorithm>
#include <cmath>

// In powers of t, with d the duration and D = P1 - P0:
//   P(t) = P0 + v0 t + c t^2 + e t^3,
//   c = (3 D / d - 2 v0 - v1) / d,   e = (v0 + v1 - 2 D / d) / d^2.
// Speed is a parabola, v0 + 2 c t + 3 e t^2, whose vertex lies at t = -c / (3 e);
// acceleration is the line 2 c + 6 e t, largest at one of the two ends.

namespace intaglio::motion {
namespace {

struct Powers {
  Vec3 square;
  Vec3 cube;
};

Powers PowersOf(const KnotState& from, const Segment& to, double duration_s) {
  const Vec3 mean_mm_s = (to.end_position_mm - from.position_mm) / duration_s;
  const Vec3& v0 = from.velocity_mm_s;
  const Vec3& v1 = to.end_velocity_mm_s;
  return {(3.0 * mean_mm_s - 2.0 * v0 - v1) / duration_s,
          (v0 + v1 - 2.0 * mean_mm_s) / (duration_s * duration_s)};
}

}  // namespace

Vec3 HermitePosition(const KnotState& from, const Segment& to, double seconds,
                     double duration_s) {
  const double u = seconds / duration_s;
  const double h01 = u * u * (3.0 - 2.0 * u);
  const double h10 = u * (u - 1.0) * (u - 1.0);
  const double h11 = u * u * (u - 1.0);
  return (1.0 - h01) * from.position_mm + h01 * to.end_position_mm +
         duration_s * (h10 * from.velocity_mm_s + h11 * to.end_velocity_mm_s);
}

Vec3 HermiteAcceleration(const KnotState& from, const Segment& to, double seconds,
                         double duration_s) {
  const Powers powers = PowersOf(from, to, duration_s);
  return 2.0 * powers.square + 6.0 * seconds * powers.cube;
}

Vec3 HermiteJerk(const KnotState& from, const Segment& to, double duration_s) {
  return 6.0 * PowersOf(from, to, duration_s).cube;
}

Vec3 MaxSpeed(const KnotState& from, const Segment& to, double duration_s) {
  const Powers powers = PowersOf(from, to, duration_s);
  Vec3 largest = from.velocity_mm_s.cwiseAbs().cwiseMax(to.end_velocity_mm_s.cwiseAbs());
  for (int axis = 0; axis < 3; ++axis) {
    const double c = powers.square[axis];
    const double e = powers.cube[axis];
    // The vertex -c / (3 e) lies inside 0..d; written without the division, so that a
    // vanishing cube (constant acceleration) needs no case of its own.
    const bool inside = c * e < 0.0 && std::abs(c) < 3.0 * std::abs(e) * duration_s;
    if (inside) {
      const double vertex_mm_s = from.velocity_mm_s[axis] - c * c / (3.0 * e);
      largest[axis] = std::max(largest[axis], std::abs(vertex_mm_s));
    }
  }
  return largest;
}

Vec3 MaxAcceleration(const KnotState& from, const Segment& to, double duration_s) {
  const Powers powers = PowersOf(from, to, duration_s);
  const Vec3 at_start = 2.0 * powers.square;
  const Vec3 at_end = at_start + 6.0 * duration_s * powers.cube;
  return at_start.cwiseAbs().cwiseMax(at_end.cwiseAbs());
}

}  // namespace intaglio::motion
