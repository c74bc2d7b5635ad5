#pragma once

// Where the front of a slab meets the seam above it, half a row of points is missing on
// average. This moves the points below the seam a little, each to one of its candidates,
// so that the gap is shared among several rows, and adds points where there is room then.

#include "engrave/discretize/spacing/point_source.h"
#include "engrave/discretize/spacing/thinning.h"

namespace intaglio::discretize {

/// How far below a seam points move, in reaches.
inline constexpr double kEvenOutReaches = 4;

/// Moves those of `kept` that have an own spacing and lie from `from_mm` up, along
/// options.rise, among the `candidates` of their source, and appends new ones. `fixed`
/// points stay where they are. The rules of Thin hold afterwards if they held before. The
/// result depends on the sets of points, and on the sequence of `kept`. No rule reaches
/// farther than reach_mm.
void EvenOut(const SpacedCloud& candidates, const SpacedCloud& fixed, double from_mm,
             double reach_mm, const ThinningOptions& options, SpacedCloud& kept);

}  // namespace intaglio::discretize
