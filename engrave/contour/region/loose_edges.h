#pragma once

// Edges in any order and direction, as drawings have them, joined to closed loops.

#include <vector>

#include "engrave/contour/edge.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

/// Joins ends nearer than tolerance_mm to each other; of several the one that was drawn
/// next and begins where the last one ends, else the nearest. Each edge
/// is moved to begin where the one before ends. Edges without a length are left out. A
/// loop begins with its first edge, and ends where it comes back and no edge goes on.
/// Fails with kInvalidValue and the place where a loop does not close.
Result<std::vector<Edges>> JoinLoops(const Edges& edges, double tolerance_mm);

}  // namespace intaglio::contour
