#pragma once

// No two points nearer than the minimum spacing, over the whole block, whatever method or
// model they came from. Frame glass, mm.

#include "engrave/core/geometry.h"

namespace intaglio::discretize {

/// A subset of the cloud such that the distance of any two kept points is at least
/// min_spacing_mm (> 0), exactly: the squared distance, computed in doubles, is not less
/// than min_spacing_mm * min_spacing_mm; and such that every point left out is nearer
/// than that to a kept one. The result, its order included, depends on the points alone,
/// not on the order in which they come: points are taken from the lowest up, by z, then
/// y, then x, then source. Memory and time grow with the points.
PointCloud WeldToSpacing(const PointCloud& cloud, double min_spacing_mm);

}  // namespace intaglio::discretize
