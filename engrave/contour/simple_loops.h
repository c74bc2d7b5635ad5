#pragma once

// Checks the loops of a free outline and gives them their direction.

#include <vector>

#include "engrave/contour/edge.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

/// The loops with their area to the left: outer ones counter-clockwise, holes clockwise,
/// islands in holes counter-clockwise again. Errors are kInvalidValue and name the place:
/// no loop, a loop without an area, edges that cross or touch apart from ends. A loop
/// that comes back to a corner becomes several.
Result<std::vector<Edges>> OrientedLoops(const std::vector<Edges>& loops);

/// Whether the edge is one of those whose odd number puts the point inside of loops.
bool CountsInLoops(const Edge& edge, const Vec2& point_mm);

/// True where an odd number of the loops encloses the point. On an edge: either.
bool IsInLoops(const Edges& edges, const Vec2& point_mm);

}  // namespace intaglio::contour
