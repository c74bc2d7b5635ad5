#pragma once

#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::discretize {

struct ContourSpacing {
  double distance_mm = 1;  ///< wanted along the contour
  double phase_ratio = 0;  ///< of the distance, by which the first point is shifted
  bool insert_end_points = true;
};

/// Points at equal arc length along a polyline, appended to `points`. The remainder is
/// spread evenly, so the distance is never below the wanted one but for its chord on
/// sharp bends, and above it by less than one part in the number of points plus 0.4 %.
/// A contour shorter than the distance gets one point.
void AddContourPoints(const PointList& contour_mm, bool closed,
                      const ContourSpacing& spacing, PointList& points);

}  // namespace intaglio::discretize
