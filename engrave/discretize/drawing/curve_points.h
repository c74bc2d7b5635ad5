#pragma once

// Curves of a drawing, and flat text, as points at equal arc length in N layers
// (Trochimczuk 2008, "Divide Curves": its ranges and defaults).

#include <memory>

#include "engrave/core/result.h"
#include "engrave/discretize/spacing/point_source.h"
#include "engrave/drawing/flatten.h"

namespace intaglio::discretize {

/// How the inside of closed curves is defined. Even-odd: places within an odd number of
/// curves, whatever their direction; for drawings. Non-zero: places that the curves wind
/// round, so that strokes may overlap; for text.
enum class CurveFill { kNone, kEvenOdd, kNonZero };

struct CurveOptions {
  /// Along the curves and in the fill, mm; 0.01 .. 100. The source uses 0.09 for
  /// f = 43 mm and 0.13 for f = 70 mm.
  double distance_mm = 1;
  int layer_count = 1;           ///< 1 .. 10
  double layer_distance_mm = 0;  ///< 0 .. 50; positive when there are several layers
  /// From each layer to the next, glass frame, not zero; its length does not matter.
  /// Default upwards; a placed drawing's normal is linear * z.
  Vec3 layer_direction = Vec3::UnitZ();
  /// 0 .. 1 of the distance, by which each next layer of a closed curve starts later. One
  /// with corners has points on them in the layers without a shift, and in the others by
  /// this much behind each.
  double twist_phase_ratio = 0;
  /// Points on the very ends of open curves; else half a distance from them.
  bool insert_end_points = true;
  /// A point on every corner that is at least the distance from the previous one, and
  /// equal arc length between them. Without it drawings would lose their corners.
  bool keep_corners = true;
  /// What the direction turns by at a corner, 0.1 .. 3. Above the turn that flattening
  /// leaves (0.05), below the 45 degrees of an octagon.
  double corner_rad = 0.45;
  CurveFill fill = CurveFill::kNone;
};

/// The points of the drawing, which is already in the glass frame. The points of a filled
/// inside keep the distance from the outline's points and from each other; no place
/// inside is farther than about 1.1 distances from a point. Errors: kTooLarge (more
/// points than candidate_limit.h allows), kUnsupported (fill of a closed curve that is
/// not flat, or of several planes at an angle). Broken preconditions: options outside
/// their ranges.
Result<std::unique_ptr<PointSource>> MakeCurvePoints(const drawing::FlatDrawing& placed,
                                                     const CurveOptions& options);

}  // namespace intaglio::discretize
