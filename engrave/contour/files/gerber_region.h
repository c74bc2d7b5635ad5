#pragma once

// Regions of Gerber files as outlines.

#include "engrave/contour/element.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

/// One path as loops. A path whose end is not its beginning is closed by a line, as all
/// viewers do; some layout programs leave the last line out. Layout programs make a hole
/// by a cut-in: a line to the hole and the same line back. Such pairs are left out, which
/// divides the path into loops; so are parts of lines that are run back, lines beyond a
/// corner and back, and lines below 0.1 um, which rounding leaves. Loops may touch at
/// corners. Loops without an area, which show nothing, are left out: a line there and
/// back gives none. Fails with a sentence without a place when the rest is no loops.
Result<Outline> RegionOutline(const Edges& path);

}  // namespace intaglio::contour
