#pragma once

// The speed along a contour under a limit on its error: the whole contour is predicted,
// the speed of each node raised or lowered until the worst error near it is the
// tolerance, and the result is measured once more with the axes' own equations. Both
// errors of contour_error.h are kept, with limits on speed, acceleration, jerk and on
// the acceleration of the motors.
//
// Source of the task: Zarudnev 2007; its law (source_law.h) takes each corner alone.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/executor.h"
#include "engrave/course/tracking.h"

namespace intaglio::course {

class SwingTable;

struct PlanOptions {
  double tolerance_mm = 0.1;         ///< 1e-4..10, of both errors
  double acceleration_mm_s2 = 2000;  ///< along the path, 1..1e6
  /// Along the path: the law is smoothed for it. Of a compensated course also of each
  /// axis.
  std::optional<double> jerk_mm_s3;
  /// Of each axis' motor, in mm of the load. A compensated course needs one.
  std::optional<double> motor_mm_s2;
  bool compensate = false;
  /// Length of the compensating kernel; default: the fastest of a series.
  std::optional<double> kernel_s;
  double period_s = 0.0005;  ///< of the setpoints
  /// The share of the tolerance that is planned for, 0.05..1; the rest is for what the
  /// model does not know (margin.h).
  double planned_ratio = 1;
  int rounds = 16;  ///< of correction, 1..100
  /// Of a compensated course of at most 20 000 segments:
  /// corners may be passed with swings (swing.h) where that is faster.
  bool swing = true;
  /// The swings of corners, kept for several contours with the same axes; null: each
  /// contour makes its own. The plan does not depend on it.
  std::shared_ptr<SwingTable> swings;
  /// For the parts of a long course; the plan does not depend on it.
  Executor executor;
};

struct NodeFigures {
  double speed_mm_s = 0;
  double one_sided_mm = 0;
  double node_miss_mm = 0;
};

struct CoursePlan {
  SpeedLaw law;
  TrackingOptions tracking;
  double acceleration_mm_s2 = 0;   ///< along the path, that was chosen
  std::vector<NodeFigures> nodes;  ///< for each node of the path
  double worst_one_sided_mm = 0, worst_node_miss_mm = 0;
  double motor_mm_s2 = 0;  ///< greatest
  double jerk_mm_s3 = 0;   ///< of the load, greatest
  /// Whether tolerance, motor and jerk are kept. They are not when the axes miss the path
  /// however slowly the corners are passed: `reason` names the node.
  bool holds = false;
  std::string reason;

  double worst_mm() const {
    return worst_one_sided_mm > worst_node_miss_mm ? worst_one_sided_mm
                                                   : worst_node_miss_mm;
  }
};

/// kInvalidValue with the option's name; kMissing: compensation without motor_mm_s2.
Status CheckOptions(const PlanOptions& options);

/// Errors as of CheckOptions.
Result<CoursePlan> PlanCourse(const Path& path, const AxisPair& axes,
                              const PlanOptions& options);

/// The setpoints of a plan and what axes `real` make of them: a course on this path,
/// from rest to rest.
Tracked FollowPlan(const Path& path, const CoursePlan& plan, const AxisPair& axes,
                   const AxisPair& real);

/// What a law without correction makes of the path, e.g. that of source_law.h.
CoursePlan EvaluateLaw(const Path& path, const AxisPair& axes, const SpeedLaw& law,
                       const PlanOptions& options);

}  // namespace intaglio::course
