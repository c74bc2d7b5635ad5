#pragma once

// The planned speeds of contours as feeds of a program (engrave/course). A controller of
// the grbl family passes a corner no faster than the feeds of the two moves that meet
// there, and accelerates between: so moves are divided beside each corner that has a
// limit, and the parts there have the corner's speed. What a machine makes of such a
// program is predicted with the law of the controller, and the speed of each corner is
// raised or lowered until the error near it is the tolerance.
//
// Frame: that of the files, mm.

#include "engrave/course/plan.h"
#include "proto/machine.pb.h"
#include "services/job/course/course_work.h"

namespace intaglio::cli {

struct PlannedFeeds {
  std::vector<post::ToolPath> paths;  ///< the same ways in moves with speeds
  /// The controller has to keep to this along the path; the speeds hold for no more.
  double acceleration_mm_s2 = 0;
  /// With a smaller junction deviation the controller passes some corner slower than
  /// planned.
  double junction_deviation_mm = 0;
  double worst_mm = 0;  ///< predicted error of a contour, and of its nodes
  double work_s = 0;
};

/// Plans contours that start and end at rest, each with its tabs as one way. Errors as of
/// CourseAxesOf and PlanCourse; kUnsupported: a contour, by its name, that is outside of
/// the tolerance however slowly its corners are passed.
Result<PlannedFeeds> PlanFeeds(const std::vector<post::ToolPath>& paths,
                               double speed_mm_s, const MachineSpec& machine);

}  // namespace intaglio::cli
