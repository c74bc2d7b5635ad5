#pragma once

// What `intaglio course plan` plans: the contours of a drawing, and the axes and limits
// of a machine profile.

#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "engrave/course/plan.h"
#include "proto/drive.pb.h"
#include "proto/machine.pb.h"

namespace intaglio::cli {

/// The curves of a drawing (.dxf, .svg, .hpgl, .plt) in its own frame, mm; open curves
/// that meet are joined. Arcs become chords that are within a micrometre of them. What
/// the file holds that is no curve is added to `warnings`.
Result<std::vector<course::Path>> ReadContours(const std::string& file, double feed_mm_s,
                                               double size_limits, Warnings& warnings);

/// The axes x and y of a profile, each by its own drive. kUnsupported: axes that turn, a
/// drive with zeros: a servo with derivative gain or feed-forward, a stepper with a
/// screw, a planar drive.
Result<course::AxisPair> AxesOf(const MachineSpec& machine);

/// Reads a drive profile: its axes x and y, or its first two. A servo without derivative
/// gain and feed-forward is of second order, w = sqrt(K / tau), xi = 1 / (2 sqrt(K tau));
/// kUnsupported: others, named by axis and field. kMissing: fewer than two axes.
Result<course::AxisPair> AxesOf(const DriveProfile& profile);

/// Speed, acceleration and jerk that both axes have, mm/s, mm/s^2, mm/s^3; the tolerance
/// is the profile's.
double FeedOf(const MachineSpec& machine);
course::PlanOptions CourseLimitsOf(const MachineSpec& machine);

}  // namespace intaglio::cli
