#pragma once

// A mark as the lines and arcs that a controller of axes follows. Frame: of the piece,
// mm.

#include "engrave/contour/edge.h"
#include "engrave/mark/mark.h"

namespace intaglio::drivers {

/// The ways of a mark, the closing one among them; a way below 0.01 um is left out, and
/// an arc that bends by less than 0.1 um is a line. Empty: the mark is a place.
contour::Edges EdgesOfMark(const mark::Mark& mark);

}  // namespace intaglio::drivers
