#include "engrave/sort/cone_order.h"

#include <cstdint>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/sort/beam/remaining_points.h"

namespace intaglio::sort {

Order KeepToCone(const PointList& points_mm, const Order& order, const BeamCone& cone) {
  RequireUsable(cone);
  RemainingPoints remaining(points_mm, order, 1);
  Order kept;
  kept.reserve(order.size());
  // Each waits for the one on top of it, which is lower: so the chain has an end.
  std::vector<std::uint32_t> waiting;
  for (const std::uint32_t next : order) {
    if (!remaining.IsLeft(next)) continue;
    waiting.push_back(next);
    while (!waiting.empty()) {
      const std::uint32_t point = waiting.back();
      if (const auto shaded = remaining.FindShaded(points_mm[point], cone)) {
        waiting.push_back(*shaded);
        continue;
      }
      waiting.pop_back();
      remaining.Take(point);
      kept.push_back(point);
    }
  }
  return kept;
}

}  // namespace intaglio::sort
