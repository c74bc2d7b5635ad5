#pragma once

// Outlines of many short edges as fewer lines, and their insets. Frame: drawing, mm.
//
// Zones of layout programs and curves that were divided have edges far shorter than a
// tool is wide. The tool's discs along n such edges overlap each other by the tool's
// radius over the length of an edge: n^2 pairs for an inset as wide as the outline. So an
// inset is made in stages of a few lengths of an edge, which is exact (what is at least a
// + b inside is at least b inside of what is at least a inside), and between them the
// outline is simplified: after a stage of a mm its roundings have a radius of a or more,
// so its edges can be about as long as sqrt(8 a t) with a tolerance t.

#include "engrave/contour/region/region.h"

namespace intaglio::contour {

/// Runs of edges as lines, arcs as chords, that are nowhere farther from the run than
/// tolerance_mm > 0, nor the run from them; a loop keeps its first point. Loops that are
/// nearer to each other, or to themselves, than twice the tolerance may cross. Time
/// n log n.
Region Simplified(const Region& region, double tolerance_mm);

/// More than 256: an inset is worth its stages.
bool HasManyEdges(const Region& region);

/// An inset whose border lies at distance_mm from that of the region to within
/// tolerance_mm, simplified. Nothing that is farther inside than both together is
/// missing. Memory and time grow with the edges, not with their pairs. Errors as of
/// Inset.
Result<Region> InsetInStages(const Region& region, double distance_mm,
                             double tolerance_mm);

}  // namespace intaglio::contour
