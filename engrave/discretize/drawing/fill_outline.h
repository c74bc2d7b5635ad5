#pragma once

// Even points inside closed curves of one plane.

#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::discretize {

struct OutlineFill {
  double distance_mm = 1;  ///< minimum, from the kept points and between the new ones
  bool even_odd = true;    ///< else non-zero winding
};

/// Appends points inside the closed polygons: a hexagonal lattice, then as many points as
/// still fit between it and the points `kept_mm` of the outline. No place inside is
/// farther than about 1.1 distances from a point. Plane x y, mm. kTooLarge as in
/// candidate_limit.h.
Status AddInnerPoints(const std::vector<std::vector<Vec2>>& polygons_mm,
                      const std::vector<Vec2>& kept_mm, const OutlineFill& fill,
                      std::vector<Vec2>& points_mm);

}  // namespace intaglio::discretize
