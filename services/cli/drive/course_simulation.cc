#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>
#include <vector>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/drive/two_axes.h"
#include "engrave/io/atomic_file.h"
#include "engrave/render/chart.h"
#include "engrave/render/png_file.h"
#include "services/cli/drive/simulate_options.h"

namespace intaglio::cli {
namespace {

constexpr double kSimulatedTurns = 100;

Status CheckTwoAxes(const DriveSimulateOptions& options, const DriveProfile& profile) {
  const auto refuse = [](const char* flag, double value, const char* why) {
    return Fail(ErrorCode::kInvalidValue, fmt::format("{} {:g}: {}", flag, value, why),
                fmt::format("{:g}", value));
  };
  if (profile.axes_size() < 2) {
    return Fail(ErrorCode::kMissing,
                "axes: a circle and a corner need two of them in the profile");
  }
  if (options.circle_mm && options.corner_deg)
    return refuse("--corner", *options.corner_deg, "give it or --circle, not both");
  if (options.step)
    return refuse("--step", options.length_mm, "is of one axis; leave it out");
  if (options.corner_deg && !(*options.corner_deg > 0 && *options.corner_deg < 180))
    return refuse("--corner", *options.corner_deg, "is not between 0 and 180 degrees");
  if (options.turns < 1 || options.turns > kSimulatedTurns)
    return refuse("--turns", options.turns, "is not in 1..100");
  const double period_s = profile.controller().period_s();
  if (!options.circle_mm) {
    const double ramp_s = 2 * options.speed_mm_s / options.acceleration_mm_s2;
    return CheckSampleCount(
        2 * options.length_mm / options.speed_mm_s + 2 * ramp_s + options.rest_s,
        period_s);
  }
  const double turn_s = 2 * std::numbers::pi * *options.circle_mm / options.speed_mm_s;
  if (turn_s < 8 * period_s)
    return refuse("--circle", *options.circle_mm,
                  "is less than 8 periods of the controller a turn; reduce --speed");
  return CheckSampleCount(options.turns * turn_s, period_s);
}

Status WriteTwoAxisTable(const std::string& file, double period_s,
                         const drive::TwoAxisRun& run) {
  std::string text =
      "time_s,x_setpoint_m,y_setpoint_m,x_m,y_m,x_following_error_m,"
      "y_following_error_m,x_volt,y_volt\n";
  for (std::size_t i = 0; i < run.setpoints_m.size(); ++i) {
    const drive::AxisSample &x = run.axes[0][i], &y = run.axes[1][i];
    text += fmt::format("{},{},{},{},{},{},{},{},{}\n", static_cast<double>(i) * period_s,
                        run.setpoints_m[i].x(), run.setpoints_m[i].y(), x.position_m,
                        y.position_m, x.following_error_m, y.following_error_m, x.volt,
                        y.volt);
  }
  return io::WriteFileAtomically(file, std::string_view(text));
}

Status WriteCoursePicture(const std::string& file, double period_s,
                          const drive::TwoAxisRun& run, const DriveCourse& course) {
  render::Curve x{"x", {}}, y{"y", {}};
  for (std::size_t i = 0; i < run.setpoints_m.size(); ++i) {
    const double t_ms = 1e3 * static_cast<double>(i) * period_s;
    x.points.emplace_back(t_ms, 1e6 * run.axes[0][i].following_error_m);
    y.points.emplace_back(t_ms, 1e6 * run.axes[1][i].following_error_m);
  }
  x.name = course.axes(0).axis(), y.name = course.axes(1).axis();
  return render::WritePng(
      file, render::DrawChart({x, y}, {"Following errors, " + course.course(), "time, ms",
                                       "error, um"}));
}

Result<drive::TwoAxisRun> RunOf(const DriveSimulateOptions& options,
                                const drive::TwoAxes& axes) {
  const double speed_m_s = options.speed_mm_s / 1000;
  if (options.circle_mm)
    return drive::SimulateCircle(axes,
                                 {*options.circle_mm / 1000, speed_m_s, options.turns});
  return drive::SimulateCorner(
      axes,
      {options.length_mm / 1000, speed_m_s, options.acceleration_mm_s2 / 1000,
       *options.corner_deg * std::numbers::pi / 180, options.stops, options.rest_s});
}

std::string CourseText(const DriveSimulateOptions& options) {
  if (options.circle_mm) {
    return fmt::format("circle of {:g} mm at {:g} mm/s, {}", *options.circle_mm,
                       options.speed_mm_s, Counted(options.turns, "turn"));
  }
  return fmt::format("corner of {:g} degrees at {:g} mm/s{}", *options.corner_deg,
                     options.speed_mm_s, options.stops ? ", with a stop" : "");
}

}  // namespace

Result<DriveCourse> SimulateCourse(const DriveSimulateOptions& options,
                                   const DriveProfile& profile) {
  INTAGLIO_TRY(CheckTwoAxes(options, profile));
  const drive::TwoAxes axes = {SimulatedAxis(options, profile, profile.axes(0)),
                               SimulatedAxis(options, profile, profile.axes(1))};
  const drive::TwoAxisRun run = INTAGLIO_TRY(RunOf(options, axes));
  DriveCourse course;
  course.set_course(CourseText(options));
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> setpoints;
    for (const Vec2& setpoint : run.setpoints_m) setpoints.push_back(setpoint[axis]);
    *course.add_axes() = FiguresOfAxis(profile.axes(axis).name(), setpoints,
                                       run.axes[static_cast<std::size_t>(axis)]);
  }
  course.set_outside_um(1e6 * run.outside_m);
  course.set_inside_um(1e6 * run.inside_m);
  course.set_settled_outside_um(1e6 * run.settled_outside_m);
  course.set_settled_inside_um(1e6 * run.settled_inside_m);
  if (!options.csv.empty())
    INTAGLIO_TRY(WriteTwoAxisTable(options.csv, axes[0].period_s, run));
  if (!options.picture.empty())
    INTAGLIO_TRY(WriteCoursePicture(options.picture, axes[0].period_s, run, course));
  return course;
}

void PrintCourse(const DriveCourse& course) {
  std::cout << fmt::format("course        {}\n", course.course());
  for (const DriveSimulation& axis : course.axes()) {
    std::cout << fmt::format(
        "axis          {}: error {:.5g} um largest, {:.5g} um at the end; {:.4g} V "
        "largest\n",
        axis.axis(), axis.max_error_um(), axis.end_error_um(), axis.max_output_v());
  }
  std::cout << fmt::format("contour       {:.5g} um outside, {:.5g} um inside at most\n",
                           course.outside_um(), course.inside_um());
  if (course.settled_outside_um() > 0 || course.settled_inside_um() > 0) {
    std::cout << fmt::format(
        "settled       {:.5g} um outside, {:.5g} um inside behind the first turn\n",
        course.settled_outside_um(), course.settled_inside_um());
  }
}

}  // namespace intaglio::cli
