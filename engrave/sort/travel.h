#pragma once

// How far the stage travels for an order.

#include "engrave/core/geometry.h"
#include "engrave/sort/order.h"

namespace intaglio::sort {

/// Sums over the steps from point to point, mm.
struct Travel {
  /// Of the largest axis distance of each step: with equal axes that one decides how long
  /// the step takes (Trochimczuk 2008 ch. 6.2).
  double largest_axis_mm = 0;
  double euclidean_mm = 0;
  double longest_step_mm = 0;  ///< by the largest axis distance
};

/// points_mm: any frame, mm. order: indices into it, all or some.
Travel MeasureTravel(const PointList& points_mm, const Order& order);

}  // namespace intaglio::sort
