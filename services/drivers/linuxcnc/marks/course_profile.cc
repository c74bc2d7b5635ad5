#include "services/drivers/linuxcnc/marks/course_profile.h"

#include <fmt/format.h>

#include <string>
#include <utility>

#include "services/drivers/interface/mark_edges.h"
#include "services/job/checks/axis_check.h"
#include "services/job/plan/course_motion.h"

namespace intaglio::drivers {
namespace {

constexpr double kTravelChord_mm = 0.001, kLongestContour_s = 3600;

void CheckCourseAxis(bool present, const std::string& name, const AxisLimits& axis,
                     std::vector<Error>& errors) {
  CheckAxis(present, axis, name, errors);
  if (!present) return;
  const auto wrong = [&](const char* field, const std::string& what) {
    errors.push_back({ErrorCode::kInvalidValue, name + "." + field + ": " + what, ""});
  };
  if (!(axis.max_speed_mm_s() > 0)) {
    wrong("max_speed_mm_s", fmt::format("{:g} is not above 0; give that of the axis",
                                        axis.max_speed_mm_s()));
  }
  if (!(axis.max_acceleration_mm_s2() >= 1)) {
    wrong("max_acceleration_mm_s2", fmt::format("{:g} is below 1; give that of the axis",
                                                axis.max_acceleration_mm_s2()));
  }
}

Status RefuseBeamPen(const mark::Pen& pen, const std::string& what) {
  return Fail(ErrorCode::kUnsupported, fmt::format("pen {:?}: {}", pen.name, what));
}

bool TravelIncludes(const AxisLimits& axis, double at_mm) {
  return at_mm >= axis.travel_min_mm() && at_mm <= axis.travel_max_mm();
}

}  // namespace

std::vector<Error> CheckLinuxcncCourseProfile(const MachineSpec& machine) {
  std::vector<Error> errors;
  if (machine.course_tool().kind() != COURSE_TOOL_LASER) {
    errors.push_back(
        {ErrorCode::kUnsupported,
         fmt::format("course_tool.kind: {}: linuxcnc-course switches a laser "
                     "along contours; give COURSE_TOOL_LASER, or write a "
                     "program for a spindle by `intaglio post`",
                     CourseToolKind_Name(machine.course_tool().kind())),
         CourseToolKind_Name(machine.course_tool().kind())});
  }
  CheckCourseAxis(machine.has_x(), "x", machine.x(), errors);
  CheckCourseAxis(machine.has_y(), "y", machine.y(), errors);
  if (!(machine.position_tolerance_um() > 0)) {
    errors.push_back({ErrorCode::kMissing,
                      "position_tolerance_um: is missing; give how far the beam may be "
                      "from a contour",
                      ""});
  }
  if (!errors.empty()) return errors;
  if (const auto axes = CourseAxesOf(machine); !axes) errors.push_back(axes.error());
  return errors;
}

Status CheckBeamPen(const mark::Pen& pen, const MachineSpec& machine) {
  if (pen.depth_mm > 0) {
    return RefuseBeamPen(pen,
                         fmt::format("a depth of {:g} mm is of a spindle, and "
                                     "course_tool.kind is a laser; give a power of 1",
                                     pen.depth_mm));
  }
  if (pen.power_ratio != 1) {
    return RefuseBeamPen(pen,
                         fmt::format("a power of {:g}: the output of LinuxCNC's HAL is "
                                     "on or off; give 1, and set the power at the laser",
                                     pen.power_ratio));
  }
  if (pen.frequency_hz > 0) {
    return RefuseBeamPen(pen, fmt::format("the beam has no pulses of {:g} Hz; leave the "
                                          "frequency out",
                                          pen.frequency_hz));
  }
  if (pen.speed_mm_s > CourseFeedOf(machine)) {
    return RefuseBeamPen(pen,
                         fmt::format("a speed of {:g} mm/s is more than the {:g} of the "
                                     "axes x and y (max_speed_mm_s); reduce it",
                                     pen.speed_mm_s, CourseFeedOf(machine)));
  }
  return {};
}

Status CheckBeamMark(const NumberedMark& mark, const mark::Pen& pen,
                     const MachineSpec& machine) {
  if (mark::IsRow(mark.mark)) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("mark {}: is a row of dots, and the beam is not switched on "
                            "its way; use contours",
                            mark.number));
  }
  if (EdgesOfMark(mark.mark).empty()) {
    return Fail(
        ErrorCode::kUnsupported,
        fmt::format("mark {}: is a place without a way; make it a circle", mark.number));
  }
  if (const double seconds = mark::LengthOf(mark.mark) / pen.speed_mm_s;
      seconds > kLongestContour_s) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("mark {}: takes {:.0f} s once around at {:g} mm/s, and a "
                            "contour is planned up to {:.0f} s; raise the speed, or "
                            "divide it",
                            mark.number, seconds, pen.speed_mm_s, kLongestContour_s));
  }
  const Vector3& origin_mm = machine.block_origin_mm();
  for (const Vec2& place_mm : mark::PlacesOf(mark.mark, kTravelChord_mm)) {
    const double x_mm = place_mm.x() + origin_mm.x(), y_mm = place_mm.y() + origin_mm.y();
    if (TravelIncludes(machine.x(), x_mm) && TravelIncludes(machine.y(), y_mm)) continue;
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("mark {}: {:.3f}, {:.3f} mm of the axes is outside the travel of x, "
                    "{:g} .. {:g}, and y, {:g} .. {:g}; correct block_origin_mm of the "
                    "profile, or the place of the contours",
                    mark.number, x_mm, y_mm, machine.x().travel_min_mm(),
                    machine.x().travel_max_mm(), machine.y().travel_min_mm(),
                    machine.y().travel_max_mm()));
  }
  return {};
}

}  // namespace intaglio::drivers
