#pragma once

// A V-shaped tool (V-bit) cuts the wider the deeper it goes: at the surface its cut is
//   tip + 2 depth tan(angle / 2)
// wide, and this is the diameter of the tool for everything that is made beside a
// contour.

#include "proto/course.pb.h"

namespace intaglio {

/// Both its tip and its angle are given.
bool IsVBit(const Course& course);

/// mm, at the surface, of a V-bit that is `depth_mm` below it.
double WidthOfVBit(const Course& course, double depth_mm);

}  // namespace intaglio
