#include "services/job/plan/course_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/drive/motor.h"
#include "services/job/drive/drive_profile.h"
#include "services/job/machine/machine_drives.h"

namespace intaglio {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

/// A servo without derivative gain and feed-forward: tau x'' + x' = K (c - x).
Result<course::AxisDynamics> SecondOrderOf(const std::string& owner,
                                           double position_gain_per_s,
                                           double velocity_time_s) {
  course::AxisParameters parameters;
  parameters.bandwidth_rad_s = std::numeric_limits<double>::infinity();
  parameters.natural_rad_s = std::sqrt(position_gain_per_s / velocity_time_s);
  parameters.damping_ratio = 1 / (2 * std::sqrt(position_gain_per_s * velocity_time_s));
  constexpr double kMinDamping = 0.01, kMaxDamping = 5;
  if (parameters.damping_ratio < kMinDamping || parameters.damping_ratio > kMaxDamping) {
    return Fail(
        ErrorCode::kUnsupported,
        fmt::format("{}: the damping {:.3g} of its loop is outside {}..{}; change "
                    "its position gain",
                    owner, parameters.damping_ratio, kMinDamping, kMaxDamping));
  }
  return course::AxisDynamics(parameters);
}

/// Reads them from a drive of the machine profile.
Result<course::AxisDynamics> DynamicsOf(const std::string& owner,
                                        const drive::DriveParameters& drive) {
  const std::vector<double>& v = drive.values;
  course::AxisParameters axis;
  axis.bandwidth_rad_s = axis.natural_rad_s = std::numeric_limits<double>::infinity();
  if (drive.name == "first_order") {
    if (v[0] > 0) axis.bandwidth_rad_s = 1 / v[0];
    return course::AxisDynamics(axis);
  }
  if (drive.name == "second_order") {
    axis.natural_rad_s = kTurn * v[0];
    axis.damping_ratio = v[1];
    return course::AxisDynamics(axis);
  }
  if (drive.name == "cascade") {
    axis.loop = course::LoopKind::kCascade;
    axis.bandwidth_rad_s = v[0];
    axis.natural_rad_s = kTurn * v[1];
    axis.damping_ratio = v[2];
    return course::AxisDynamics(axis);
  }
  if (drive.name == "servo" && v[2] == 0 && v[3] == 0)
    return SecondOrderOf(owner + ": servo", v[0], v[1]);
  return Fail(
      ErrorCode::kUnsupported,
      fmt::format("{}: drive: {}: courses are planned for stage_lag_s, "
                  "second_order, cascade and a servo with derivative_ratio 0 and "
                  "feed_forward_ratio 0; describe the axes x and y by one of them",
                  owner, drive.name));
}

Result<course::AxisDynamics> ServoAxisOf(const DriveProfile& profile,
                                         const DriveAxis& axis) {
  const DrivePanel& panel = axis.panel();
  if (panel.derivative_s() != 0 || panel.feed_forward_ratio() != 0) {
    return Fail(ErrorCode::kUnsupported,
                profile.name() + ": axis " + axis.name() +
                    ": panel: courses are planned for servos with derivative_s 0 and "
                    "feed_forward_ratio 0; set them so");
  }
  const drive::ServoLoop servo =
      drive::CloseAxis(VelocityLoopOf(axis, drive::CylinderRule::kSolid),
                       PositionLoopOf(profile, axis), axis.screw().lead_m());
  return SecondOrderOf(profile.name() + ": axis " + axis.name(),
                       servo.position_gain_per_s, servo.velocity_time_s);
}

}  // namespace

Result<course::AxisPair> CourseAxesOf(const MachineSpec& machine) {
  if (machine.has_head_over_block()) {
    return Fail(ErrorCode::kUnsupported,
                machine.name() +
                    ": kinematics: head_over_block: has mirrors; courses are planned for "
                    "linear axes x and y");
  }
  if (machine.has_polar()) {
    return Fail(ErrorCode::kUnsupported,
                machine.name() +
                    ": kinematics: polar: has an arm and a table; courses are "
                    "planned for linear axes x and y");
  }
  const auto drives = DriveParametersOf(machine);
  std::vector<course::AxisDynamics> axes;
  for (const std::size_t i : {0, 1}) {
    auto axis = INTAGLIO_TRY(DynamicsOf(machine.name(), drives[i]));
    axes.push_back(std::move(axis));
  }
  return course::AxisPair{axes[0], axes[1]};
}

Result<course::AxisPair> CourseAxesOf(const DriveProfile& profile) {
  if (profile.axes_size() < 2) {
    return Fail(ErrorCode::kMissing, profile.name() +
                                         ": axes: a course needs two, x and y; add the "
                                         "one that is missing");
  }
  const auto index_of = [&](std::string_view name, int otherwise) {
    for (int i = 0; i < profile.axes_size(); ++i)
      if (profile.axes(i).name() == name) return i;
    return otherwise;
  };
  std::vector<course::AxisDynamics> axes;
  for (const int i : {index_of("x", 0), index_of("y", 1)}) {
    auto axis = INTAGLIO_TRY(ServoAxisOf(profile, profile.axes(i)));
    axes.push_back(std::move(axis));
  }
  return course::AxisPair{axes[0], axes[1]};
}

double CourseFeedOf(const MachineSpec& machine) {
  return std::min(machine.x().max_speed_mm_s(), machine.y().max_speed_mm_s());
}

course::PlanOptions CourseLimitsOf(const MachineSpec& machine) {
  course::PlanOptions options;
  options.acceleration_mm_s2 = std::min(machine.x().max_acceleration_mm_s2(),
                                        machine.y().max_acceleration_mm_s2());
  options.tolerance_mm = machine.position_tolerance_um() / 1000;
  for (const AxisLimits* axis : {&machine.x(), &machine.y()}) {
    if (!axis->has_max_jerk_mm_s3()) continue;
    options.jerk_mm_s3 = std::min(options.jerk_mm_s3.value_or(axis->max_jerk_mm_s3()),
                                  axis->max_jerk_mm_s3());
  }
  return options;
}

Result<course::Path> CoursePathAlong(
    const contour::Edges& edges,
    const std::function<double(std::size_t edge)>& feed_mm_s) {
  std::vector<course::Piece> pieces;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (edges[i].length_mm < course::kMinSegmentMm) continue;
    pieces.push_back({edges[i].end_mm, feed_mm_s(i), edges[i].sweep_rad});
  }
  return course::Path::Make(edges.empty() ? Vec2(0, 0) : edges.front().begin_mm, pieces);
}

Result<course::Path> CoursePathAlong(const contour::Edges& edges, double feed_mm_s) {
  return CoursePathAlong(edges, [&](std::size_t) { return feed_mm_s; });
}

}  // namespace intaglio
