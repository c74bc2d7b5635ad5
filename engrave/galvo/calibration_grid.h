#pragma once

// The grid of discs by which the field of a scan head is measured: nodes a pitch apart
// around the middle of the field, and one disc between the nodes that shows how a picture
// of them is turned.
//
//   o   o   o        +y
//         *          |
//   o   o   o        +-- +x
//
//   o   o   o
//
// The disc between the nodes lies on no line by which the grid is symmetric, so that each
// of the eight ways to lay the piece down has it elsewhere. Frame field: mm.

#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::galvo {

/// kInvalidValue: `nodes` a side is not odd or outside 5..65, `pitch_mm` not above 0.
Status CheckCalibrationGrid(int nodes, double pitch_mm);

/// Row by row, lowest first; the numbers are checked.
std::vector<Vec2> CalibrationGrid(int nodes, double pitch_mm);

/// Of the disc between the nodes.
inline Vec2 DirectionDisc(double pitch_mm) { return {0.5 * pitch_mm, 0.25 * pitch_mm}; }

}  // namespace intaglio::galvo
