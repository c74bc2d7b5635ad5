#include "services/cli/contour/contour_command.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>

#include <cctype>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/lower_case.h"
#include "services/cli/complain.h"
#include "services/cli/contour/contour_figures.h"
#include "services/cli/contour/contour_files.h"
#include "services/cli/contour/contour_frames.h"
#include "services/cli/contour/contour_motion.h"
#include "services/cli/contour/contour_page.h"
#include "services/cli/contour/contour_picture.h"
#include "services/cli/contour/contour_programs.h"
#include "services/cli/contour/contour_project.h"
#include "services/cli/flags/size_limits_flag.h"
#include "services/cli/job_options.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/client/warning_text.h"
#include "services/job/course/course_check.h"
#include "services/job/course/course_work.h"
#include "services/job/job_check.h"
#include "services/job/job_file.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct ContourOptions {
  std::vector<std::string> files;
  std::string make = "isolation", order = "improved", corners = "sharp";
  std::string layer;
  bool inside = false;
  std::optional<double> lead_mm, tool_mm, overlap, speed_mm_s, travel_mm_s, plunge_mm_s,
      depth_mm, power, safe_mm, tab_distance_mm, tab_width_mm, tab_height_mm,
      drill_depth_mm, chord_um, axis_speed_deg_s;
  std::optional<std::uint32_t> tabs, passes, repeat, max_bytes;
  std::vector<double> start_mm, origin_mm;
  bool chords = false;
  std::string mill_template, drill_template, out, picture, xml, frames, page, machine,
      drill_units;
  std::optional<double> frame_step_s;
  double size_limits = 1;
};

constexpr std::string_view kMakePrefix = "COURSE_MAKE_";

/// COURSE_MAKE_OUTLINE is outline.
std::vector<std::string> MakeNames() {
  std::vector<std::string> names;
  for (int i = 0; i < CourseMake_descriptor()->value_count(); ++i) {
    const std::string name = CourseMake_descriptor()->value(i)->name();
    names.push_back(io::LowerCase(std::string_view(name).substr(kMakePrefix.size())));
  }
  return names;
}

CourseMake MakeOf(const std::string& name) {
  std::string value(kMakePrefix);
  for (const char c : name)
    value += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  CourseMake make = COURSE_MAKE_ISOLATION;
  Require(CourseMake_Parse(value, &make), "--make '{}' has passed its check", name);
  return make;
}

/// What is given on the command line.
Course TypedCourse(const ContourOptions& options) {
  Course course;
  for (const std::string& file : options.files) course.add_files(file);
  course.set_make(MakeOf(options.make));
  course.set_round_corners(options.corners == "round");
  course.set_nearest_order(options.order == "nearest");
  if (!options.layer.empty()) course.set_layer(options.layer);
  if (options.inside) course.set_inside(true);
  if (options.lead_mm) course.set_lead_mm(*options.lead_mm);
  if (options.tabs) course.set_tab_count(*options.tabs);
  if (options.tab_distance_mm) course.set_tab_distance_mm(*options.tab_distance_mm);
  if (options.tab_width_mm) course.set_tab_width_mm(*options.tab_width_mm);
  if (options.tab_height_mm) course.set_tab_height_mm(*options.tab_height_mm);
  if (options.tool_mm) course.set_tool_diameter_mm(*options.tool_mm);
  if (options.passes) course.set_pass_count(*options.passes);
  if (options.overlap) course.set_overlap_ratio(*options.overlap);
  if (options.speed_mm_s) course.set_speed_mm_s(*options.speed_mm_s);
  if (options.travel_mm_s) course.set_travel_mm_s(*options.travel_mm_s);
  if (options.plunge_mm_s) course.set_plunge_mm_s(*options.plunge_mm_s);
  if (options.depth_mm) course.set_depth_mm(*options.depth_mm);
  if (options.power) course.set_power_ratio(*options.power);
  if (options.repeat) course.set_repeat_count(*options.repeat);
  if (options.safe_mm) course.set_safe_height_mm(*options.safe_mm);
  if (options.drill_depth_mm) course.set_drill_depth_mm(*options.drill_depth_mm);
  return course;
}

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
  if (options.mill_template.empty() || course.has_tool_diameter_mm()) return {};
  const auto program = INTAGLIO_TRY(ReadMillTemplate(options.mill_template));
  if (const double radius_mm = program.SettingOf("tool-radius", 0); radius_mm > 0)
    course.set_tool_diameter_mm(2 * radius_mm);
  return {};
}

Vec2 PlaceOf(const std::vector<double>& xy_mm) {
  return xy_mm.empty() ? Vec2(0, 0) : Vec2(xy_mm[0], xy_mm[1]);
}

Status WritePrograms(const ContourOptions& options, const ContourWork& work,
                     const Course& whole, const Course& typed) {
  if (options.out.empty()) return {};
  ContourProgramOptions program;
  program.mill_template = options.mill_template;
  program.drill_template = options.drill_template;
  program.out = options.out;
  program.mill.chords = options.chords || options.chord_um;
  if (options.chord_um) program.mill.chord_tolerance_mm = *options.chord_um / 1000;
  if (options.max_bytes) program.mill.max_bytes = *options.max_bytes;
  program.mill.axis_speed_deg_s = options.axis_speed_deg_s;
  program.mill.origin_mm = PlaceOf(options.origin_mm);
  const auto files = INTAGLIO_TRY(WriteContourPrograms(work, whole, typed, program));
  for (const fs::path& file : files) fmt::print("program       {}\n", file.string());
  return {};
}

/// The motion in time, when it is asked for.
Status Simulate(const ContourOptions& options, const ContourWork& work,
                const Course& whole) {
  if (options.frames.empty() && options.page.empty() && options.machine.empty())
    return {};
  std::optional<MachineSpec> machine;
  if (!options.machine.empty()) {
    const fs::path profile = INTAGLIO_TRY(FindMachineFile(options.machine));
    machine = INTAGLIO_TRY(ReadMachineFile(profile));
  }
  const ContourMotion motion = INTAGLIO_TRY(
      MotionOf(work, whole, machine ? &*machine : nullptr, PlaceOf(options.start_mm)));
  if (machine) {
    fmt::print("{:<13} {} at work within {:g} um, {} in all\n", machine->name(),
               client::ShortDuration(motion.work_s), machine->position_tolerance_um(),
               client::ShortDuration(motion.duration_s));
  }
  if (motion.not_held > 0) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("{} of {} contours: {} cannot keep its tolerance of {:g} um "
                            "there however slow it is; use another machine, or a greater "
                            "position_tolerance_um",
                            motion.not_held, work.paths.size(), machine->name(),
                            machine->position_tolerance_um()));
  }
  if (!options.page.empty() && motion.duration_s > 0) {
    const std::string title = fs::path(options.files[0]).filename().string();
    INTAGLIO_TRY(io::WriteFileAtomically(
        options.page, PageOf(work, motion, whole.tool_diameter_mm(), title)));
    fmt::print("page          {}\n", options.page);
  }
  if (options.frames.empty()) return {};
  FrameOptions frames;
  frames.folder = options.frames;
  frames.step_s = options.frame_step_s;
  const auto count =
      INTAGLIO_TRY(WriteFrames(work, motion, whole.tool_diameter_mm(), frames));
  fmt::print("frames        {} in {}\n", count, options.frames);
  return {};
}

Status MakeContours(const ContourOptions& options) {
  const JobSpec job = INTAGLIO_TRY(ReadCourseJob(options));
  Course typed = job.course();
  INTAGLIO_TRY(TakeToolOf(options, typed));
  const Course whole = WithDefaults(typed);
  Warnings warnings;
  const auto read =
      ReadCourseFiles(whole, options.size_limits, warnings, options.drill_units);
  for (const Warning& warning : warnings)
    std::cerr << client::WarningLine(warning) << "\n";
  if (!read) return tl::unexpected(read.error());
  const CourseFiles& files = *read;
  const Vec2 start_mm = PlaceOf(options.start_mm);
  const ContourWork work = INTAGLIO_TRY(MakeContourWork(whole, files, start_mm));
  for (const std::string& line : FiguresOf(work, whole)) fmt::print("{}\n", line);
  if (!options.xml.empty()) {
    const auto project = INTAGLIO_TRY(ProjectOf(files));
    INTAGLIO_TRY(io::WriteFileAtomically(options.xml, contour::WriteProject(project)));
  }
  if (!options.picture.empty()) {
    INTAGLIO_TRY(io::WriteFileAtomically(
        options.picture, SvgOf(work, start_mm, whole.tool_diameter_mm())));
  }
  INTAGLIO_TRY(Simulate(options, work, whole));
  return WritePrograms(options, work, whole, typed);
}

void AddToolOptions(command_line::Command contour, ContourOptions& options) {
  contour
      .AddOption("--make", options.make,
                 "isolation: around the copper, so that its nets are cut apart; outline: "
                 "once around everything; curves: along the curves of drawings; pocket: "
                 "clear what they enclose; cut: parts out of a sheet")
      .OneOf(MakeNames())
      .ShowDefault();
  contour
      .AddOption("--tool", options.tool_mm,
                 "mm, the tool's diameter, of a laser the kerf; default the template's, "
                 "else 0.2")
      .Within(0.001, 100.0);
  contour.AddOption("--passes", options.passes, "of an isolation, default 1")
      .Within(1, 20);
  contour.AddOption("--overlap", options.overlap, "of passes, by the tool, default 0.5")
      .Within(0.5, 0.95);
  contour.AddOption("--layer", options.layer,
                    "of a board of KiCad, e.g. B.Cu; default its first of copper");
  contour.AddOption("--drill-units", options.drill_units,
                    "of drill files that declare none: the line of their header, e.g. "
                    "INCH,TZ or METRIC,LZ,000.000");
  contour
      .AddOption("--lead", options.lead_mm,
                 "of cuts: mm, radius of the arc on which the tool comes and goes")
      .Within(0.01, 1000.0);
  contour.AddFlag("--inside", options.inside,
                  "of cuts: openings into a sheet, and not parts out of it");
  contour
      .AddOption("--corners", options.corners,
                 "of outlines: sharp as published, or round as the tool leaves them")
      .OneOf({"sharp", "round"})
      .ShowDefault();
  contour
      .AddOption("--order", options.order,
                 "improved, or to the nearest contour as published")
      .OneOf({"improved", "nearest"})
      .ShowDefault();
  contour.AddOption("--start", options.start_mm, "mm, x and y where the tool comes from")
      .TakeValues(2);
}

void AddTabOptions(command_line::Command contour, ContourOptions& options) {
  const auto count = contour
                         .AddOption("--tabs", options.tabs,
                                    "of cuts: how many hold each part, default 0")
                         .Within(0, 1000);
  contour
      .AddOption("--tab-distance", options.tab_distance_mm,
                 "of cuts: mm, how far apart tabs are at most, in place of their number")
      .Within(0.1, 10000.0)
      .Exclude(count);
  contour.AddOption("--tab-width", options.tab_width_mm, "mm of material left, default 3")
      .Within(0.01, 1000.0);
  contour
      .AddOption("--tab-height", options.tab_height_mm,
                 "mm above the depth, of mills; default half of the depth")
      .Within(0.01, 100.0);
}

void AddMotionOptions(command_line::Command contour, ContourOptions& options) {
  contour.AddOption("--speed", options.speed_mm_s, "mm/s at work, default 5")
      .Within(0.01, 10000.0);
  contour.AddOption("--travel", options.travel_mm_s, "mm/s between, default 50")
      .Within(0.01, 10000.0);
  contour
      .AddOption("--plunge", options.plunge_mm_s, "mm/s down, default the speed at work")
      .Within(0.01, 10000.0);
  const auto depth =
      contour.AddOption("--depth", options.depth_mm, "mm below the surface, default 0.2")
          .Within(0.0, 100.0);
  contour.AddOption("--power", options.power, "of a laser, 0..1 of its largest")
      .Within(0.0, 1.0)
      .Exclude(depth);
  contour
      .AddOption("--repeat", options.repeat,
                 "times each contour is made, deeper by an equal part; default 1")
      .Within(1, 100);
  contour.AddOption("--safe", options.safe_mm, "mm above the surface, between, default 2")
      .Within(0.01, 1000.0);
  contour.AddOption("--drill-depth", options.drill_depth_mm, "mm, default 3")
      .Within(0.01, 100.0);
}

void AddProgramOptions(command_line::Command contour, ContourOptions& options) {
  const auto mill = contour.AddOption("--template", options.mill_template,
                                      "of the program: a name in deploy/post/mill (grbl, "
                                      "grbl-laser, hpgl, krl, krl-full, "
                                      "linuxcnc, sinumerik), or a file");
  const auto out = contour.AddOption("--out", options.out, "the program").Need(mill);
  contour
      .AddOption("--drill-template", options.drill_template,
                 "of the holes: a name in deploy/post/drill, or a file; default the name "
                 "of the template")
      .Need(out);
  contour.AddOption("--origin", options.origin_mm, "mm, x and y that become 0 0")
      .TakeValues(2)
      .Need(out);
  contour.AddFlag("--chords", options.chords, "lines in place of arcs").Need(out);
  contour
      .AddOption("--chord-tolerance", options.chord_um,
                 "um, of lines in place of arcs; default the template's, 1")
      .Within(0.1, 1000.0)
      .Need(out);
  contour
      .AddOption("--max-bytes", options.max_bytes,
                 "maximum size of a program; longer ones are divided")
      .Within(200, 1'000'000'000)
      .Need(out);
  contour
      .AddOption("--axis-speed", options.axis_speed_deg_s,
                 "deg/s, maximum of a lathe's turning axis; default the template's")
      .Within(0.01, 100000.0)
      .Need(out);
}

}  // namespace

void AddContourCommand(command_line::Command app) {
  auto options = std::make_shared<ContourOptions>();
  command_line::Command contour = app.AddCommand(
      "contour", "contours and holes of circuit boards and plates, and their programs");
  contour
      .AddOption("FILE", options->files,
                 "Gerber, Excellon, .kicad_pcb, project .xml, or drawings .dxf .svg "
                 ".hpgl .plt, all in "
                 "one frame")
      .Require();
  AddToolOptions(contour, *options);
  AddTabOptions(contour, *options);
  AddMotionOptions(contour, *options);
  AddProgramOptions(contour, *options);
  contour.AddOption("--picture", options->picture,
                    "SVG, 1:1: copper, contours by pass, idle ways, holes");
  contour.AddOption("--xml", options->xml, "the elements and holes as a project");
  const auto frames =
      contour.AddOption("--frames", options->frames,
                        "folder of an animation: PNG files and a table of them");
  contour
      .AddOption("--frame-step", options->frame_step_s,
                 "s between frames, default a hundredth of the time")
      .Within(0.001, 1000.0)
      .Need(frames);
  contour.AddOption("--page", options->page,
                    "HTML: play, pause, stop and feed of the work in a browser");
  contour.AddOption(
      "--machine", options->machine,
      "profile whose drive follows: time, frames and page with planned speeds");
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
