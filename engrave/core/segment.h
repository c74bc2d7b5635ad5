#pragma once

#include <algorithm>

#include "engrave/core/geometry.h"

namespace intaglio {

/// Square of the distance of p from the segment from a to b, in the plane (Vec2) or in
/// space (Vec3); a and b may be one point.
template <typename Vector>
double SquaredDistanceFromSegment(const Vector& p, const Vector& a, const Vector& b) {
  const Vector along = b - a;
  const double square = along.squaredNorm();
  const double share =
      square > 0 ? std::clamp((p - a).dot(along) / square, 0.0, 1.0) : 0.0;
  return (p - a - share * along).squaredNorm();
}

}  // namespace intaglio
