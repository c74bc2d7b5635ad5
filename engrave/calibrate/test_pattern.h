#pragma once

// The points of a machine's test: rows of marks that are passed in both directions of x
// and of y, slowly and fast, at places all over the block, again and again. From where
// the marks come to lie, machine_fit.h finds what is wrong with the axes.
//
//   slow and fast columns (y)   | | | |
//                               | | | |     one of stations^2 such groups
//   slow and fast rows (x)      - - - -
//
// The order of the marks follows from their heights: each row lies a layer above the one
// before, so that the order `boustrophedon` of layer_mm and row_width_mm makes them in
// sequence and in the intended directions. Frame glass, mm.

#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::calibrate {

struct TestPatternOptions {
  Vec3 block_mm = Vec3::Constant(50);  ///< sides; x and y of 25 mm or more
  double margin_mm = 3;                ///< of the block's sides without marks, >= 0
  /// Between two marks of a slow and of a fast row: speeds are in the same ratio, for a
  /// lamp sync passes from mark to mark.
  double slow_step_mm = 0.3, fast_step_mm = 1.2;
  int marks_per_row = 6;  ///< 3..50
  int stations = 3;       ///< along each side, 2..10
};

struct TestPattern {
  PointList marks_mm;  ///< in the order in which they are to be made
  double layer_mm = 0.01;
  double row_width_mm = 0.1;
};

/// kInvalidValue: the block has no room for the stations, or for the layers; it gives the
/// smallest size.
Result<TestPattern> MakeTestPattern(const TestPatternOptions& options);

}  // namespace intaglio::calibrate
