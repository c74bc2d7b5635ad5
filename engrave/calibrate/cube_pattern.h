#pragma once

// The points of a test cube for a scan head over a block: a square grid of points at each
// of several depths. From where they come to lie, cube_fit.h finds what is wrong with the
// head. From above no two of them cover each other: the columns and rows of a level lie
// between those of the level below. The first point has two more beside it, along +x and
// +y, so that a block that was turned or is seen from below is recognized.

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::calibrate {

struct CubePatternOptions {
  Box3 box_mm;     ///< that the marks fill, glass frame, mm
  int nodes = 5;   ///< of a side of a level, 3..41
  int levels = 2;  ///< 2..10
};

struct CubePattern {
  PointList marks_mm;  ///< level by level from below, row by row in +y, along +x
  PointList signs_mm;  ///< both points beside the first mark
};

/// kInvalidValue: numbers out of range, or marks nearer than a millimetre; it gives the
/// size that the box needs.
Result<CubePattern> MakeCubePattern(const CubePatternOptions& options);

}  // namespace intaglio::calibrate
