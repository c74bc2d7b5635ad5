#pragma once

#include <cstdint>
#include <optional>

#include "engrave/core/result.h"
#include "engrave/drawing/drawing.h"

namespace intaglio::drawing {

/// A curve as a polyline. Also closed when its end coincides with its beginning. It does
/// not repeat its first point, and no point coincides with the previous one.
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
  /// Maximum deviation of the polyline from the curve, mm; 1e-6 .. 1. A micrometre is
  /// below the resolution of every stage.
  double chord_tolerance_mm = 0.001;
  /// Maximum turn of a curve within one segment, rad; 0.01 .. 1. A chord is shorter than
  /// its arc by angle^2 / 24: with 0.05 rad lengths are accurate to 1e-4 however small
  /// the curve is.
  double max_turn_rad = 0.05;
  std::uint64_t max_points = 10'000'000;  ///< beyond is kTooLarge
};

/// The curves as polylines, in the frame of the drawing. Corners, where two pieces join
/// at an angle, stay points.
Result<FlatDrawing> Flatten(const Drawing& drawing, const FlattenOptions& options = {});

/// One curve; nullopt: it has no point, or more than the limit.
std::optional<FlatCurve> FlattenCurve(const Curve& curve);

/// Joins open curves end to end into longer ones, closed where they come back, when
/// exactly two ends of the same layer are nearer than the tolerance: CAD programs write
/// an outline as single lines and arcs. The order of curves is that of their first part.
void JoinOpenCurves(double tolerance_mm, FlatDrawing& flat);

/// Of closed curves that coincide, in either direction and from any start, the first is
/// kept: drawings contain a shape both as a hatch and as an outline, and by the even-odd
/// rule the inside of both would be outside. The tolerance is positive. The comparison
/// ends after half a second; curves not compared by then are kept.
void RemoveRepeatedContours(double tolerance_mm, FlatDrawing& flat);

}  // namespace intaglio::drawing
