#pragma once

// Points as planned against what a machine has made, as sets with multiplicity: a machine
// that pauses, or a computer that is too busy, makes them in another order than the plan.

#include <string>

#include "engrave/core/geometry.h"

namespace intaglio::testing {

/// A line for each of `made_mm` that is farther than `tolerance_mm` from every point or
/// makes one again, and the number of points that were not made. Empty: each point was
/// made exactly once, and nothing else.
std::string PointDifference(const PointList& points_mm, const PointList& made_mm,
                            double tolerance_mm);

}  // namespace intaglio::testing
