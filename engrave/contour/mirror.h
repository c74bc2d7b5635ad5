#pragma once

// Elements as they are seen from the other side of the board: mirrored about a line along
// y. Frame: drawing, mm, x to the right, y up.

#include "engrave/contour/element.h"

namespace intaglio::contour {

/// (x, y) becomes (2 line_x_mm - x, y). Arcs stay exact and turn the other way round.
Vec2 Mirrored(const Vec2& place_mm, double line_x_mm);
Edge Mirrored(const Edge& edge, double line_x_mm);
Shape Mirrored(const Shape& shape, double line_x_mm);

}  // namespace intaglio::contour
