#include "services/cli/course/course_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>

#include "engrave/core/try.h"
#include "engrave/render/png_file.h"
#include "services/cli/course/course_job.h"
#include "services/cli/course/course_program.h"
#include "services/cli/flags/drive_profile_flag.h"
#include "services/cli/flags/size_limits_flag.h"
#include "services/cli/json/print_json.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/job/drive/drive_profile.h"
#include "services/job/files/job_file.h"
#include "services/job/plan/course_motion.h"
#include "services/platform/command_line/supplied_files.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct CourseOptions {
  std::string file, machine, drive, csv, picture;
  std::optional<double> feed_mm_s, tolerance_um, motor_mm_s2, kernel_ms, jerk_mm_s3;
  std::optional<double> acceleration_mm_s2;
  double period_ms = 0.5, frequency_percent = 5, damping_percent = 20;
  double size_limits = 1;
  bool compensate = false, reserve = false, json = false;
};

course::PlanOptions PlanOptionsOf(const CourseOptions& options,
                                  const MachineSpec& machine) {
  course::PlanOptions plan = CourseLimitsOf(machine);
  if (options.tolerance_um) plan.tolerance_mm = *options.tolerance_um / 1000;
  plan.acceleration_mm_s2 = options.acceleration_mm_s2.value_or(plan.acceleration_mm_s2);
  if (options.jerk_mm_s3) plan.jerk_mm_s3 = options.jerk_mm_s3;
  plan.compensate = options.compensate;
  if (options.compensate)
    plan.motor_mm_s2 = options.motor_mm_s2.value_or(plan.acceleration_mm_s2);
  if (options.kernel_ms) plan.kernel_s = *options.kernel_ms / 1000;
  plan.period_s = options.period_ms / 1000;
  return plan;
}

/// A machine whose controller has the axes (a mill of grbl) has none in its profile: then
/// all that is taken of them has to be given.
Status CheckPlannedAxes(const CourseOptions& options, const MachineSpec& machine) {
  if (machine.has_x() && machine.has_y()) return {};
  std::string missing;
  const auto need = [&missing](bool given, const char* name) {
    if (!given) missing += (missing.empty() ? "" : ", ") + std::string(name);
  };
  need(options.feed_mm_s.has_value(), "--feed");
  need(options.acceleration_mm_s2.has_value(), "--acceleration");
  need(options.tolerance_um || machine.position_tolerance_um() > 0, "--tolerance");
  need(!options.drive.empty(), "--drive");
  if (missing.empty()) return {};
  return Fail(ErrorCode::kMissing,
              fmt::format("{}: its profile has no x and y, whose limits and drives a "
                          "course is planned with; give {}, or name the profile of a "
                          "machine with x and y",
                          machine.name(), missing),
              machine.name());
}

/// The axes of the drive profile, else of the machine's.
Result<course::AxisPair> AxesBy(const CourseOptions& options,
                                const MachineSpec& machine) {
  if (options.drive.empty()) return CourseAxesOf(machine);
  const DriveProfile profile = INTAGLIO_TRY(NamedDriveProfile(options.drive));
  return CourseAxesOf(profile);
}

Result<CourseProgram> MakeProgram(const CourseOptions& options) {
  const fs::path profile = INTAGLIO_TRY(
      command_line::FindSupplied(options.machine, command_line::kSuppliedProfiles));
  const MachineSpec machine = INTAGLIO_TRY(ReadMachineFile(profile));
  const course::AxisPair axes = INTAGLIO_TRY(AxesBy(options, machine));
  INTAGLIO_TRY(CheckPlannedAxes(options, machine));
  Warnings warnings;
  auto paths = INTAGLIO_TRY(
      ReadContours(options.file, options.feed_mm_s.value_or(CourseFeedOf(machine)),
                   options.size_limits, warnings));
  PrintWarningLines(warnings);
  return PlanProgram(std::move(paths), axes, PlanOptionsOf(options, machine),
                     {options.frequency_percent / 100, options.damping_percent / 100},
                     options.reserve);
}

int Plan(const CourseOptions& options) {
  const auto program = MakeProgram(options);
  if (!program) return Complain(program.error());
  if (!options.csv.empty()) {
    if (const Status written = WriteCourseTable(options.csv, *program); !written)
      return Complain(written.error());
  }
  if (!options.picture.empty()) {
    const auto picture = PictureOf(*program, fs::path(options.file).filename().string());
    if (const Status written =
            render::WritePng(options.picture, render::DrawCourse(picture));
        !written)
      return Complain(written.error());
  }
  if (options.json) {
    if (const int failed = PrintJson(ReportOf(*program)); failed != client::kExitGood)
      return failed;
  } else {
    for (const std::string& line : FiguresOf(*program)) std::cout << line << "\n";
  }
  bool good = program->holds();
  if (options.reserve) {
    for (const PlannedContour& contour : program->contours)
      good = good && contour.margin.holds;
  }
  return good ? client::kExitGood : client::kExitNotGood;
}

void AddLimits(command_line::Command plan, CourseOptions& options) {
  plan.AddOption("--feed", options.feed_mm_s,
                 "mm/s, default the greatest of the machine's axes x and y")
      .Within(course::kMinFeedMmS, course::kMaxFeedMmS);
  plan.AddOption("--tolerance", options.tolerance_um,
                 "um, of the course from the path and of the nodes from the course; "
                 "default the profile's position tolerance")
      .Within(0.1, 10000.0);
  plan.AddOption("--acceleration", options.acceleration_mm_s2,
                 "mm/s^2 along the path, default that of the axes")
      .Within(1.0, 1e6);
  plan.AddOption("--jerk", options.jerk_mm_s3, "mm/s^3, default that of the axes")
      .Within(1.0, 1e12);
  const auto compensate = plan.AddFlag(
      "--compensate", options.compensate,
      "setpoints by the inverse of the axes, so that they do not lag behind");
  plan.AddOption("--motor", options.motor_mm_s2,
                 "mm/s^2, greatest of each motor; default the acceleration")
      .Within(1.0, 1e9)
      .Need(compensate);
  plan.AddOption("--kernel", options.kernel_ms,
                 "ms, length of the compensating kernel; default the fastest")
      .Within(0.01, 1e4)
      .Need(compensate);
  plan.AddOption("--period", options.period_ms, "ms, of the setpoints")
      .Within(0.01, 100.0)
      .ShowDefault();
}

}  // namespace

void AddCourseCommand(command_line::Command app) {
  const command_line::Command course =
      app.AddCommand("course", "contours that are cut or marked without a stop");
  course.RequireCommand();
  auto options = std::make_shared<CourseOptions>();
  command_line::Command plan = course.AddCommand(
      "plan", "plan the speed along contours so that the deviation is kept");
  plan.AddOption("FILE", options->file, "drawing: .dxf, .svg, .hpgl, .plt or .nci")
      .Require();
  plan.AddOption("--machine", options->machine,
                 "profile: a file, or the name of a supplied one")
      .Require();
  plan.AddOption("--drive", options->drive,
                 "drive profile, a file or a supplied one, whose axes x and y follow; "
                 "default the machine's drive");
  AddLimits(plan, *options);
  plan.AddFlag("--reserve", options->reserve,
               "plan so that the tolerance is kept with wrong mechanics too");
  plan.AddOption("--wrong-frequency", options->frequency_percent,
                 "%, how wrong the axes' natural frequency may be")
      .Within(0.0, 50.0)
      .ShowDefault();
  plan.AddOption("--wrong-damping", options->damping_percent,
                 "%, how wrong their damping may be")
      .Within(0.0, 50.0)
      .ShowDefault();
  plan.AddOption("--csv", options->csv, "the course, one row for each setpoint");
  plan.AddOption("--picture", options->picture,
                 "PNG: the contours with the deviation magnified, the speed along them");
  plan.AddFlag("--json", options->json, "the figures for programs");
  AddSizeLimitsFlag(plan, options->size_limits);
  plan.SetFooter(
      "Example: intaglio course plan drawing.dxf --machine els-03 --feed 60 --tolerance "
      "50 --compensate --picture course.png\n"
      "Exit code: 0 good, 2 wrong input, 3 the tolerance is not kept.");
  plan.SetAction([options] { return Plan(*options); });
  course.SetFooter("Example: intaglio course plan drawing.dxf --machine els-03");
}

}  // namespace intaglio::cli
