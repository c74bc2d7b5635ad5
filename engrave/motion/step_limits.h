#pragma once

// The limits of a step on each axis, derived from all limits.
//
// Limits of an axis by itself, jerk and travel included, keep the axes independent, and
// what is planned with them is exact but for acceleration 0 at the points where jerk is
// limited. A limit on the length of a vector does not: a ball is no box. It is kept
// conservatively, by boxes inscribed in it. Each gives every axis a share of the length,
// the squares of the shares adding up to 1, and a step takes the box that serves it best.

#include <cstdint>
#include <vector>

#include "engrave/motion/axis/axis_reach.h"
#include "engrave/motion/axis/limits.h"

namespace intaglio::motion {

struct StepLimits {
  Limits whole;  ///< The limits that the motion keeps. Limits of vector lengths are
                 ///< already included in those per axis.
  /// Less what a course needs whose arcs begin and end on the grid. A speed limit stays
  /// positive while the axis takes longer to reach it than a few steps of the grid.
  Limits planned;
  /// The grid, 1/65536 tick; a power of two. At least 0.2 us: over shorter times the
  /// last bit of a coordinate shows as acceleration (1.4e-14 mm of 100 mm: 2 mm/s^2);
  /// where jerk is limited, as long as its last bit stays below a thousandth of that.
  std::uint64_t grid_subticks = 1;

  bool jerk_limited(int axis) const { return whole.max_jerk_mm_s3[axis] < kUnlimited; }
};

/// The boxes a step may choose from: one where no length is limited. What one box allows
/// at the end of a step, it allows at the start of the next.
std::vector<StepLimits> StepLimitsOf(const Limits& limits, double rate_hz);

/// Whether a way through points in `extent_mm` comes so near to a wall that the speed is
/// limited there.
bool NearWalls(const std::vector<StepLimits>& choices, const Box3& extent_mm,
               double rate_hz);

/// Whether only speed and acceleration per axis are limited, apart from the travel. Away
/// from the ends of the travel the planner's inner loops are compiled for that case,
/// because every comparison there costs time, and once more for all other cases.
bool IsPlain(const std::vector<StepLimits>& choices);

/// The speeds with which one axis can pass a point: the way to the nearer wall must be
/// enough to brake, or to have come from. Exact (axis_reach.h: the course at full
/// acceleration needs no more of it), but with limited jerk half as long again as full
/// jerk needs, which not every course can have. 0 at the wall and beyond it. `slack_mm`
/// is added to the way.
SpeedInterval SpeedsAt(double position_mm, int axis, const StepLimits& limits,
                       double rate_hz, double slack_mm = 0);

}  // namespace intaglio::motion
