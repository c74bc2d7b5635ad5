#pragma once

// A mark as setpoints of the axes x and y, one for each servo period, from rest to rest:
// planned with look-ahead by the planner of courses (engrave/course/plan.h), compensated,
// so that axes with the drives of the profile are where the smoothed reference is,
// without lag, and corners are passed as fast as the tolerance allows.

#include <cstddef>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/mark/mark.h"
#include "proto/machine.pb.h"

namespace intaglio::drivers {

struct ContourPlan {
  /// Frame of the piece, mm.
  std::vector<Vec2> setpoints_mm;
  /// Of these in which the axes are on the way by their model, and the beam is on: from
  /// lit_begin on, up to and without lit_end.
  std::size_t lit_begin = 0, lit_end = 0;
  /// Behind the last setpoint, until the axes rest.
  std::size_t settle_count = 0;
  double duration_s = 0;  ///< of the planned law, without what the kernel adds
};

/// `period_s`: of the servo thread. Once around, at the speed of the pen; `machine` has
/// passed CheckLinuxcncCourseProfile. kInvalidValue, kMissing: what the planner does not
/// take, by name; kUnsupported: the tolerance of the profile cannot be kept. Throws when
/// `progress` returns false, at the latest behind a part of some thousand setpoints.
Result<ContourPlan> PlanContour(const mark::Mark& mark, const mark::Pen& pen,
                                const MachineSpec& machine, double period_s,
                                const ProgressSink& progress = {});

}  // namespace intaglio::drivers
