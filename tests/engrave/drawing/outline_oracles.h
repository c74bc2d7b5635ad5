#pragma once

// What outlines enclose, from their corners alone.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/core/segment.h"
#include "engrave/drawing/flatten.h"

namespace intaglio::drawing {

/// How often closed curves run around a point, from the angles to their corners.
inline int WindingAt(const FlatDrawing& drawing, const Vec2& at) {
  double turn = 0;
  for (const FlatCurve& curve : drawing.curves) {
    const std::size_t n = curve.points_mm.size();
    for (std::size_t i = 0; i < n; ++i) {
      const Vec2 a = curve.points_mm[i].head<2>() - at;
      const Vec2 b = curve.points_mm[(i + 1) % n].head<2>() - at;
      turn += std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    }
  }
  return static_cast<int>(std::lround(turn / (2 * std::numbers::pi)));
}

/// From the nearest curve.
inline double DistanceToCurves(const FlatDrawing& drawing, const Vec2& at) {
  double nearest = 1e300;
  for (const FlatCurve& curve : drawing.curves) {
    const std::size_t n = curve.points_mm.size();
    for (std::size_t i = 0; i + (curve.closed ? 0 : 1) < n; ++i) {
      const Vec2 a = curve.points_mm[i].head<2>();
      const Vec2 b = curve.points_mm[(i + 1) % n].head<2>();
      nearest = std::min(nearest, SquaredDistanceFromSegment(at, a, b));
    }
  }
  return std::sqrt(nearest);
}

}  // namespace intaglio::drawing
