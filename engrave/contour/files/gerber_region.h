#pragma once

// Regions of Gerber files as outlines.

#include "engrave/contour/element.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

/// One closed path as loops. Layout programs make a hole by a cut-in: a line to the hole
/// and the same line back. Such pairs are left out, which divides the path into loops.
/// Fails with a sentence without a place when the rest is no loops, or nothing.
Result<Outline> RegionOutline(const Edges& path);

}  // namespace intaglio::contour
