#include "engrave/sort/travel.h"

#include <algorithm>

#include "engrave/core/check.h"

namespace intaglio::sort {

Travel MeasureTravel(const PointList& points_mm, const Order& order) {
  for (const std::uint32_t index : order) {
    Require(index < points_mm.size(), "the order names point {} of {}", index,
            points_mm.size());
  }
  Travel travel;
  for (std::size_t i = 1; i < order.size(); ++i) {
    const Vec3 step_mm = points_mm[order[i]] - points_mm[order[i - 1]];
    const double largest_axis_mm = step_mm.cwiseAbs().maxCoeff();
    travel.largest_axis_mm += largest_axis_mm;
    travel.euclidean_mm += step_mm.norm();
    travel.longest_step_mm = std::max(travel.longest_step_mm, largest_axis_mm);
  }
  return travel;
}

}  // namespace intaglio::sort
