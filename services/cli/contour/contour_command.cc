#include "services/cli/contour/contour_command.h"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/lower_case.h"
#include "engrave/io/whole_file.h"
#include "services/cli/contour/contour_figures.h"
#include "services/cli/contour/contour_files.h"
#include "services/cli/contour/contour_frames.h"
#include "services/cli/contour/contour_motion.h"
#include "services/cli/contour/contour_options.h"
#include "services/cli/contour/contour_page.h"
#include "services/cli/contour/contour_picture.h"
#include "services/cli/contour/contour_programs.h"
#include "services/cli/contour/contour_project.h"
#include "services/cli/flags/size_limits_flag.h"
#include "services/cli/job/job_options.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/job/checks/course_check.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/convert/v_bit.h"
#include "services/job/files/job_file.h"
#include "services/job/plan/course_motion.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

bool IsJobFile(const fs::path& file) {
  const std::string extension = file.extension().string();
  return extension == ".textproto" || extension == ".txtpb" || extension == ".json";
}

/// The course of a job file, changed by what is given beside it; else what is given.
Result<JobSpec> ReadCourseJob(const ContourOptions& options) {
  JobSpec job;
  Course typed = TypedCourse(options);
  if (options.files.size() == 1 && IsJobFile(options.files[0])) {
    auto read = INTAGLIO_TRY(ReadJobFile(options.files[0]));
    if (!read.has_course()) {
      return Fail(
          ErrorCode::kInvalidValue,
          options.files[0] +
              ": has no course; name a board or a drawing, or a job with a course",
          options.files[0]);
    }
    job = std::move(read);
    typed.clear_files();
  }
  job.mutable_course()->MergeFrom(typed);
  if (const auto errors = CheckCourse(job); !errors.empty())
    return tl::unexpected(JoinErrors(errors));
  return job;
}

/// A tool that is not given is that of the template.
Status TakeToolOf(const ContourOptions& options, Course& course) {
  if (options.mill_template.empty() || course.has_tool_diameter_mm() || IsVBit(course))
    return {};
  const auto program = INTAGLIO_TRY(ReadMillTemplate(options.mill_template));
  if (const double radius_mm = program.SettingOf("tool-radius", 0); radius_mm > 0)
    course.set_tool_diameter_mm(2 * radius_mm);
  return {};
}

Vec2 PlaceOf(const std::vector<double>& xy_mm) {
  return xy_mm.empty() ? Vec2(0, 0) : Vec2(xy_mm[0], xy_mm[1]);
}

Result<post::HeightMap> ReadHeightMap(const ContourOptions& options) {
  constexpr std::size_t kMaxBytes = 64 << 20;
  const std::string text = INTAGLIO_TRY(io::ReadWholeFile(options.height_map, kMaxBytes));
  return post::ParseHeightMap(text, options.height_map, options.height_zero_mm);
}

Status WritePrograms(const ContourOptions& options, const ContourWork& work,
                     const Course& whole, const Course& typed,
                     const std::optional<MachineSpec>& machine) {
  if (options.out.empty()) return {};
  ContourProgramOptions program;
  program.mill_template = options.mill_template;
  program.drill_template = options.drill_template;
  program.out = options.out;
  program.parameters = INTAGLIO_TRY(TypedParameters(options));
  program.mill.chords = options.chords || options.chord_um;
  if (options.chord_um) program.mill.chord_tolerance_mm = *options.chord_um / 1000;
  if (options.max_bytes) program.mill.max_bytes = *options.max_bytes;
  program.mill.axis_speed_deg_s = options.axis_speed_deg_s;
  program.mill.origin_mm = PlaceOf(options.origin_mm);
  program.probe_step_mm = options.probe_step_mm;
  std::optional<post::HeightMap> heights;
  if (!options.height_map.empty()) {
    heights = INTAGLIO_TRY(ReadHeightMap(options));
    program.mill.heights = &*heights;
    fmt::print(std::cout, "surface       {} x {} heights, {:.3f} to {:.3f} mm\n",
               heights->x_mm().size(), heights->y_mm().size(), heights->min_mm(),
               heights->max_mm());
  }
  if (machine) program.machine = &*machine;
  Warnings warnings;
  const auto files =
      INTAGLIO_TRY(WriteContourPrograms(work, whole, typed, program, warnings));
  PrintWarningLines(warnings);
  for (const fs::path& file : files)
    fmt::print(std::cout, "program       {}\n", file.string());
  return {};
}

Result<std::optional<MachineSpec>> ReadMachine(const ContourOptions& options) {
  if (options.machine.empty()) return std::nullopt;
  const fs::path profile = INTAGLIO_TRY(FindMachineFile(options.machine));
  MachineSpec machine = INTAGLIO_TRY(ReadMachineFile(profile));
  INTAGLIO_TRY(CourseAxesOf(machine));
  if (!machine.has_x() || !machine.has_y()) {
    return Fail(
        ErrorCode::kMissing,
        fmt::format("--machine: the profile of {} has no x and y, whose limits and "
                    "drives speeds are planned with; leave --machine out, or name "
                    "the profile of a machine with x and y",
                    machine.name()),
        machine.name());
  }
  return machine;
}

/// The motion in time, when it is asked for.
Status Simulate(const ContourOptions& options, const ContourWork& work,
                const Course& whole, const std::optional<MachineSpec>& machine) {
  if (options.frames.empty() && options.page.empty() && !machine) return {};
  const ContourMotion motion = INTAGLIO_TRY(
      MotionOf(work, whole, machine ? &*machine : nullptr, PlaceOf(options.start_mm)));
  if (machine) {
    fmt::print(std::cout, "{:<13} {} at work within {:g} um, {} in all\n",
               machine->name(), client::ShortDuration(motion.work_s),
               machine->position_tolerance_um(),
               client::ShortDuration(motion.duration_s));
  }
  if (motion.not_held > 0) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("{} of {}: {} cannot keep its tolerance of {:g} um "
                            "there however slow it is; use another machine, or a greater "
                            "position_tolerance_um",
                            motion.not_held, Counted(work.paths.size(), "contour"),
                            machine->name(), machine->position_tolerance_um()));
  }
  if (!options.page.empty() && motion.duration_s > 0) {
    const std::string title = fs::path(options.files[0]).filename().string();
    INTAGLIO_TRY(io::WriteFileAtomically(
        options.page, PageOf(work, motion, whole.tool_diameter_mm(), title)));
    fmt::print(std::cout, "page          {}\n", options.page);
  }
  if (options.frames.empty()) return {};
  FrameOptions frames;
  frames.folder = options.frames;
  frames.step_s = options.frame_step_s;
  const auto count =
      INTAGLIO_TRY(WriteFrames(work, motion, whole.tool_diameter_mm(), frames));
  fmt::print(std::cout, "frames        {} in {}\n", count, options.frames);
  return {};
}

Status MakeContours(const ContourOptions& options) {
  const JobSpec job = INTAGLIO_TRY(ReadCourseJob(options));
  Course typed = job.course();
  INTAGLIO_TRY(TakeToolOf(options, typed));
  const Course whole = WithDefaults(typed);
  Warnings warnings;
  const Vec2 start_mm = PlaceOf(options.start_mm);
  const auto made = ContoursFromFiles(whole, options.size_limits, start_mm, warnings,
                                      TypedFileOptions(options));
  PrintWarningLines(warnings);
  if (!made) return tl::unexpected(made.error());
  const auto& [files, work] = *made;
  for (const std::string& line : FiguresOf(work, whole))
    fmt::print(std::cout, "{}\n", line);
  if (!options.xml.empty()) {
    const auto project = INTAGLIO_TRY(ProjectOf(files));
    INTAGLIO_TRY(io::WriteFileAtomically(options.xml, contour::WriteProject(project)));
  }
  if (!options.picture.empty()) {
    INTAGLIO_TRY(io::WriteFileAtomically(
        options.picture, SvgOf(work, start_mm, whole.tool_diameter_mm())));
  }
  const auto machine = INTAGLIO_TRY(ReadMachine(options));
  INTAGLIO_TRY(Simulate(options, work, whole, machine));
  return WritePrograms(options, work, whole, typed, machine);
}

}  // namespace

void AddContourCommand(command_line::Command app) {
  auto options = std::make_shared<ContourOptions>();
  command_line::Command contour = app.AddCommand(
      "contour", "contours and holes of circuit boards and plates, and their programs");
  contour
      .AddOption("FILE", options->files,
                 "Gerber, Excellon, .kicad_pcb, project .xml, or drawings .dxf .svg "
                 ".hpgl .plt .nci, all in one frame")
      .Require();
  AddContourOptions(contour, *options);
  AddSizeLimitsFlag(contour, options->size_limits);
  contour.SetFooter(
      "Example: intaglio contour board.gbr board.drl --tool 0.2 --passes 2 --template "
      "linuxcnc --out board.ngc --picture board.svg\n"
      "  intaglio contour plate.svg --make cut --tool 2 --page plate.html   without a "
      "machine: played in a browser\n"
      "Exit code: 0 written, 2 wrong input, or what cannot be made, with its place.");
  contour.SetAction([options] {
    const Status made = MakeContours(*options);
    return made ? client::kExitGood : Complain(made.error());
  });
}

}  // namespace intaglio::cli
