#pragma once

// Checks the loops of a free outline and gives them their direction.

#include <vector>

#include "engrave/contour/edge.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

/// The loops with their area to the left: outer ones counter-clockwise, holes clockwise,
/// islands in holes counter-clockwise again. Errors are kInvalidValue and name the place:
/// no loop, a loop without an area, edges that cross or touch apart from ends; kTooLarge
/// as of NearPairsUpTo. A loop that comes back to a corner becomes several.
Result<std::vector<Edges>> OrientedLoops(const std::vector<Edges>& loops);

/// The edge's part of the winding number of loops about the point: their sum is how often
/// these run around it, counter-clockwise less clockwise. On an edge: of either side.
int TurnsAround(const Edge& edge, const Vec2& point_mm);

/// Whether the edge is one of those whose odd number puts the point inside of loops.
inline bool CountsInLoops(const Edge& edge, const Vec2& point_mm) {
  return TurnsAround(edge, point_mm) % 2 != 0;
}

/// True where an odd number of the loops encloses the point. On an edge: either.
bool IsInLoops(const Edges& edges, const Vec2& point_mm);

}  // namespace intaglio::contour
