#pragma once

// How each point of a plan is passed: how fast, and from which side each axis came.

#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/motion/planner.h"

namespace intaglio::calibrate {

struct Approach {
  Vec3 speed_mm_s = Vec3::Zero();  ///< velocity of each axis at the point
  /// Of each axis: 1 upwards, -1 downwards, 0 not known, for it has turned less than
  /// kKnownAfterMm before the point.
  Vec3 direction = Vec3::Zero();
};

/// A play of the axes up to this is crossed before a direction is known, mm.
inline constexpr double kKnownAfterMm = 0.3;

/// One a point. `plan`: how the axes are driven, its drive left out; `axes`: the axes at
/// the points, in the order of engraving, not empty.
std::vector<Approach> ApproachesOf(motion::PlanOptions plan, const PointList& axes);

}  // namespace intaglio::calibrate
