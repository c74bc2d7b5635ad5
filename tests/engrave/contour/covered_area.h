#pragma once

// The area that elements cover, by scan lines: an oracle that knows nothing of contours.

#include <span>

#include "engrave/contour/union.h"

namespace intaglio::contour::test {

/// Covers circles, squares, octagons and tracks, grown with sharp corners. A line of
/// constant y meets each in one interval; their union's length is integrated over y
/// exactly: between heights where outlines meet or end it is analytic but for square
/// roots at those heights, which y = middle + half sin(t) removes, so few points of Gauss
/// suffice.
double CoveredArea_mm2(std::span<const Element> elements, double tool_radius_mm,
                       int points = 12);

}  // namespace intaglio::contour::test
