#pragma once

// Bays of a region that a disc cannot enter, cut off by straight lines: teeth of a saw,
// of a comb, spikes of noise, arms of a fractal. Frame: drawing, mm.

#include "engrave/contour/region/region.h"

namespace intaglio::contour {

/// The region, of lines alone, where discs of disc_mm radius are to be placed. Runs of
/// the border whose ends are at most neck_mm apart become one line when it lies in the
/// region and cuts off less than such a disc. A centre that keeps the radius from the
/// border keeps it from the new one to neck_mm^2 / (8 disc_mm), and reversely; neck_mm of
/// at most disc_mm / 2. What is cut off may leave islands in it, in which no disc fits:
/// inside is what an odd number of the loops encloses. Time n log n.
Region WithoutNarrowBays(const Region& region, double disc_mm, double neck_mm);

}  // namespace intaglio::contour
