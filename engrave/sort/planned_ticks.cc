#include "engrave/sort/planned_ticks.h"

#include <vector>

#include "engrave/core/check.h"
#include "engrave/motion/tick_planner.h"

namespace intaglio::sort {

std::uint64_t PlannedTicks(const PointList& points_mm, const Order& order,
                           const motion::Limits& limits, double rate_hz) {
  if (order.size() < 2) return 0;
  motion::TickPlanner planner(limits, rate_hz, motion::OptionsForRate(rate_hz),
                              {points_mm.at(order.front()), Vec3::Zero()});
  std::vector<motion::Segment> segments;
  for (std::size_t i = 1; i < order.size(); ++i) {
    planner.Append(points_mm.at(order[i]), -1, true, segments);
    segments.clear();
  }
  planner.Finish(segments);
  return planner.ticks();
}

}  // namespace intaglio::sort
