#pragma once

// What the planner of courses (engrave/course) takes of a machine: its axes x and y, each
// by its own drive, their limits, and the path of a contour.

#include <functional>

#include "engrave/contour/edge.h"
#include "engrave/core/result.h"
#include "engrave/course/plan.h"
#include "proto/drive.pb.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// The axes x and y of a profile, each by its own drive. kUnsupported: axes that turn, a
/// drive with zeros: a servo with derivative gain or feed-forward, a stepper with a
/// screw, a planar drive.
Result<course::AxisPair> CourseAxesOf(const MachineSpec& machine);

/// Reads a drive profile: its axes x and y, or its first two. A servo without derivative
/// gain and feed-forward is of second order, w = sqrt(K / tau), xi = 1 / (2 sqrt(K tau));
/// kUnsupported: others, named by axis and field. kMissing: fewer than two axes.
Result<course::AxisPair> CourseAxesOf(const DriveProfile& profile);

/// Speed, acceleration and jerk that both axes have, mm/s, mm/s^2, mm/s^3; the tolerance
/// is the profile's.
double CourseFeedOf(const MachineSpec& machine);
course::PlanOptions CourseLimitsOf(const MachineSpec& machine);

/// The path of a planner along edges, each with its feed. kMissing: no edge is longer
/// than course::kMinSegmentMm.
Result<course::Path> CoursePathAlong(
    const contour::Edges& edges,
    const std::function<double(std::size_t edge)>& feed_mm_s);
Result<course::Path> CoursePathAlong(const contour::Edges& edges, double feed_mm_s);

}  // namespace intaglio
