#pragma once

// What two axes make of one corner that is passed at constant speed, in closed form. The
// error is proportional to the speed, so it is given per unit of it, in s (mm per mm/s).
//
// Source: Zarudnev 2007, (5); the closed form is ours: with the corner at the origin at t
// = 0 and directions u0 and u1, axis i is at u0_i (t - lag_i) + (u1_i - u0_i) ramp_i(t),
// ramp(t) = t - lag + sum of c_k exp(p_k t) over the poles. It depends on the orientation
// and on which axis comes first, which the formula (6)-(8) ignores.

#include "engrave/core/geometry.h"
#include "engrave/course/axis_dynamics.h"

namespace intaglio::course {

struct CornerError {
  /// Greatest distance of the actual course from the path.
  double one_sided_s = 0;
  /// Distance of the corner from the actual course.
  double node_miss_s = 0;

  double worst_s() const { return one_sided_s > node_miss_s ? one_sided_s : node_miss_s; }
};

/// Directions of unit length before and behind the corner. The maximum may be a cusp
/// where both legs are equally far; it is refined to 1e-6 of its size.
CornerError CornerResponse(const AxisPair& axes, const Vec2& before, const Vec2& behind);

/// On a circle of radius R mm at v mm/s, settled: the greatest distance from the circle,
/// in radii, for rate = v / R rad/s.
double CircleError(const AxisPair& axes, double rate_rad_s);

}  // namespace intaglio::course
