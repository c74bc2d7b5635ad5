#pragma once

// Parts side by side by their outlines, on a raster: parts that interlock lie in each
// other's bays and holes.
//
// A part covers the cells that it may touch. A place is free if no cell that another part
// covers is nearer to it than the gap; both are rounded to the safe side by half a cell's
// diagonal, so parts are apart from each other by the gap at least, and by at most two
// diagonals more than they need be. Parts are taken by the longer side of their box, the
// longest first; each goes upright or turned by 90, 180 or 270 degrees to the place where
// its top is lowest, or its middle, and there as far left as it fits ("bottom left",
// Baker, Coffman, Rivest 1980, on rows of bits).
// Frame: sheet, mm.

#include "engrave/contour/milling/nest.h"

namespace intaglio::contour {

/// One way by the lowest top and one by the lowest middle. `options` and `parts` as of
/// NestParts, which checks them. A way is left out when a part does not fit into an empty
/// sheet on this raster; by its box it may.
std::vector<Nest> NestOutlines(std::span<const Region> parts, const NestOptions& options);

}  // namespace intaglio::contour
