#pragma once

// The planner's own cost of an order, the final measure for every sorter that takes
// motion into account.

#include <cstddef>
#include <cstdint>

#include "engrave/core/geometry.h"
#include "engrave/motion/axis/limits.h"
#include "engrave/sort/order.h"

namespace intaglio::sort {

/// Ticks from rest at the first point through all others to rest at the last, points
/// passed without a stop (motion/tick_planner.h). limits: in the frame of the points.
std::uint64_t PlannedTicks(const PointList& points_mm, const Order& order,
                           const motion::Limits& limits, double rate_hz);

/// Whether the ticks exceed the bound, one per point, by less than 0.1 %.
inline bool IsNearTheBound(std::uint64_t ticks, std::size_t points) {
  return static_cast<double>(ticks) <= 1.001 * static_cast<double>(points);
}

}  // namespace intaglio::sort
