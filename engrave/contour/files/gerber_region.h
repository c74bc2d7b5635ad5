#pragma once

// Regions of Gerber files as outlines.

#include "engrave/contour/element.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

/// One closed path as loops. Layout programs make a hole by a cut-in: a line to the hole
/// and the same line back. Such pairs are left out, which divides the path into loops; so
/// are parts of lines that are run back, lines beyond a corner and back, and lines below
/// 0.1 um, which rounding leaves. Loops may touch at corners.
/// Fails with a sentence without a place when the rest is no loops, or nothing.
Result<Outline> RegionOutline(const Edges& path);

}  // namespace intaglio::contour
