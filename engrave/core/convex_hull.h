#pragma once

// The smallest convex polygon around points of a plane, and the same with fewer corners.

#include <cstddef>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio {

/// Corners in counter-clockwise order, mm, no three in a line, from the one with the
/// least x (of several the one with the least y). One or two where the points are equal
/// or in a line; none without points. Every coordinate is a number.
std::vector<Vec2> ConvexHull(std::vector<Vec2> points);

/// At most `max_count` (1 or more) corners of a convex polygon: again and again the
/// corner goes that is nearest to the line through its neighbours. So the new polygon
/// lies within the old one, and its corners are corners of the old one.
std::vector<Vec2> WithFewerCorners(std::vector<Vec2> corners, std::size_t max_count);

}  // namespace intaglio
