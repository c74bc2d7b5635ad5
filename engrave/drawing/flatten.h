#pragma once

#include <cstdint>

#include "engrave/core/result.h"
#include "engrave/drawing/drawing.h"

namespace intaglio::drawing {

/// A curve as a polyline. Closed also when its end stands on its beginning; it does not
/// repeat its first point, and no point stands on the one before it.
struct FlatCurve {
  PointList points_mm;
  bool closed = false;
  std::uint32_t layer = 0;  ///< as in Curve
  std::uint32_t color = 0;
};

struct FlatDrawing {
  std::vector<FlatCurve> curves;
};

struct FlattenOptions {
  /// Farthest that the polyline may leave the curve, mm; 1e-6 .. 1. A micrometre is
  /// below the reach of every stage.
  double chord_tolerance_mm = 0.001;
  /// Most that a curve may turn within one segment; 0.01 .. 1. A chord is shorter than
  /// its arc by angle^2 / 24: with 0.05 rad lengths are true to 1e-4 however small the
  /// curve is.
  double max_turn_rad = 0.05;
  std::uint64_t max_points = 10'000'000;  ///< beyond is kTooLarge
};

/// The curves as polylines, in the frame of the drawing. Corners, where two pieces join
/// at an angle, stay points.
Result<FlatDrawing> Flatten(const Drawing& drawing, const FlattenOptions& options = {});

/// Joins open curves end to end into longer ones, closed where they come back, when two
/// ends of the same layer and no third are nearer than the tolerance: CAD programs write
/// an outline as single lines and arcs. The order of curves is that of their first part.
void JoinOpenCurves(double tolerance_mm, FlatDrawing& flat);

/// Of closed curves that run along each other, either way and from wherever, the first
/// stays: drawings hold a shape as its hatch and its outline, and what is inside both
/// would by even-odd be outside. The tolerance is positive; what is beyond half a second
/// of comparing stays.
void RemoveRepeatedContours(double tolerance_mm, FlatDrawing& flat);

}  // namespace intaglio::drawing
