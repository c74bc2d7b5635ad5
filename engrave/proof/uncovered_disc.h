#pragma once

// The largest disc of a surface that holds no point of the cloud: the place of the
// surface that is farthest from its nearest point.

#include "engrave/core/executor.h"
#include "engrave/core/geometry.h"
#include "engrave/proof/point_tree.h"
#include "engrave/proof/surface.h"

namespace intaglio::proof {

struct UncoveredDisc {
  double radius_mm = 0;          ///< distance of the place from the nearest point
  double upper_bound_mm = 0;     ///< no place is farther from its nearest point than this
  Vec3 place_mm = Vec3::Zero();  ///< of the surface
};

/// upper_bound_mm equals radius_mm up to rounding on ordinary surfaces. It is at most a
/// thousandth more where thousands of points are equally far from the place (a sphere of
/// them around it). `points` has at least one. The same for any executor.
UncoveredDisc LargestUncoveredDisc(const Surface& surface, const PointTree& points,
                                   const PointList& points_mm, const Executor& executor);

}  // namespace intaglio::proof
