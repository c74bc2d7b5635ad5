#pragma once

// Loops made of edges that cross, touch and run along each other, as drawings have them;
// a region has simple contours alone. Frame: drawing, mm.

#include <cstdint>
#include <functional>
#include <vector>

#include "engrave/contour/edge.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

/// How often loops are wanted to run around a point, counter-clockwise; constant between
/// edges.
using WindingAt = std::function<int(const Vec2& point_mm)>;

/// Closed loops of parts of the edges that run around every point as often as
/// `winding_at` wants, points within 10 nm of an edge excepted. Edges are longer than 10
/// nm, in any order and direction. `pairs_left` counts down the pairs of edges that are
/// compared. Errors: kTooLarge when none are left; kUnsupported where edges nearly touch
/// and no loop closes, with the place.
Result<std::vector<Edges>> LoopsOfWinding(const Edges& edges, const WindingAt& winding_at,
                                          std::uint64_t& pairs_left);

}  // namespace intaglio::contour
