#pragma once

// The ticks of the motion with a stop at each point.

#include <cstdint>
#include <vector>

#include "engrave/motion/stop_and_go.h"

namespace intaglio::motion {

/// Ticks from rest at `start_mm` through all points, without the end of the program.
inline std::uint64_t StopAndGoTicks(const PointList& points_mm, const Vec3& start_mm,
                                    const Limits& limits, double rate_hz,
                                    Profile profile) {
  StopAndGoPlanner planner(limits, rate_hz, profile, start_mm);
  std::vector<Segment> step;
  for (const Vec3& point_mm : points_mm) {
    step.clear();
    planner.Append(point_mm, -1, false, step);
  }
  return planner.ticks();
}

}  // namespace intaglio::motion
