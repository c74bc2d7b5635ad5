#include "services/cli/offline/post_command.h"

#include <fmt/format.h>
#include <fmt/ostream.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <utility>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/formats/point_file_kinds.h"
#include "engrave/io/whole_file.h"
#include "engrave/post/point_program.h"
#include "services/cli/contour/contour_files.h"
#include "services/cli/contour/contour_programs.h"
#include "services/cli/flags/accept_flag.h"
#include "services/cli/flags/size_limits_flag.h"
#include "services/cli/job/job_glass.h"
#include "services/cli/job/job_limits.h"
#include "services/cli/job/job_options.h"
#include "services/cli/offline/offline_steps.h"
#include "services/cli/offline/path_job.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/job/beams/energy_by_place.h"
#include "services/job/checks/course_check.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/fields/channels.h"
#include "services/job/machine/laser_setting.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/plan/ordering.h"
#include "services/job/plan/point_order.h"
#include "services/platform/command_line/supplied_files.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct PostOptions {
  JobFlags job;
  AcceptFlag accept;
  std::string path, program_template, out, materials_db;
};

/// A job and its points in the order of engraving, glass frame.
struct OrderedJob {
  FrozenJob job;
  PointList path_mm;
  PointEnergies energies;
};

Result<post::Template> ReadTemplate(const std::string& name_or_file) {
  const fs::path file = INTAGLIO_TRY(
      command_line::FindSupplied(name_or_file, command_line::kSuppliedTemplates));
  const std::string text = INTAGLIO_TRY(io::ReadWholeFile(file, 1 << 20));
  return post::ParsePointTemplate(text, file.string());
}

/// A controller of others opens no shutters: its program is that of one block.
Status RequireOneChannel(const JobSpec& job, std::span<const std::uint32_t> sources) {
  const auto masks =
      INTAGLIO_TRY(ChannelsOfPoints(job, {sources.begin(), sources.end()}));
  const auto other = std::ranges::adjacent_find(masks, std::ranges::not_equal_to());
  if (other == masks.end()) return {};
  return Fail(ErrorCode::kUnsupported,
              "channels: the job engraves several blocks, and a program has no shutters; "
              "make one job for each block");
}

Result<OrderedJob> OrderNamedJob(const PostOptions& options) {
  auto built = INTAGLIO_TRY(BuildJob(options.job));
  OrderedJob ordered;
  ordered.job = INTAGLIO_TRY(FreezeWithGlass(built, options.materials_db));
  const auto made =
      INTAGLIO_TRY(MakeMeteredCloud(ordered.job.job(), LimitsOf(options.job)));
  INTAGLIO_TRY(RequireOneChannel(ordered.job.job(), made.cloud.source));
  PrintWarningLines(made.warnings);
  Meter meter("order");
  const auto order = INTAGLIO_TRY(OrderPoints(
      ordered.job, made.cloud.points_mm, std::vector<ChannelMask>(made.cloud.size(), 1),
      host::OrderingOf(ordered.job), meter.Sink()));
  ordered.path_mm.reserve(order.size());
  std::vector<std::uint32_t> source;
  for (const std::uint32_t i : order) {
    ordered.path_mm.push_back(made.cloud.points_mm[i]);
    source.push_back(made.cloud.source[i]);
  }
  auto energies = INTAGLIO_TRY(EnergiesOfPoints(ordered.job, ordered.path_mm, source));
  ordered.energies = std::move(energies);
  return ordered;
}

Result<OrderedJob> TakePath(const PostOptions& options) {
  auto table = INTAGLIO_TRY(
      ReadPoints(options.path, ReadLimitsTimes(options.job.size_limits).points));
  OrderedJob ordered;
  auto job =
      INTAGLIO_TRY(BuildPathJob(options.job, table.points_mm, options.materials_db));
  INTAGLIO_TRY(RequireInBlock(job, table.points_mm));
  ordered.job = std::move(job);
  ordered.path_mm = std::move(table.points_mm);
  const std::vector<std::uint32_t> source(ordered.path_mm.size(), 0);
  ordered.energies = INTAGLIO_TRY(EnergiesOfPoints(ordered.job, ordered.path_mm, source));
  return ordered;
}

/// The settings of the laser: of the greatest energy, and of each point where they
/// differ.
Status SetPower(const OrderedJob& ordered, post::PointProgram& program) {
  const LaserHead& laser = ordered.job.machine().laser();
  const std::vector<double>& energies_mj = ordered.energies.distinct_mj;
  program.power_ratio = LaserSettingFor(laser, energies_mj.back()).value_or(1);
  if (energies_mj.size() == 1) return {};
  if (laser.energy_calibration().empty()) {
    return Fail(
        ErrorCode::kUnsupported,
        fmt::format("the models have pulse energies of {} mJ, and the profile of {} "
                    "has no laser.energy_calibration, by which a program sets "
                    "them; add it, or make a job for each energy",
                    fmt::join(energies_mj, ", "), ordered.job.machine().name()));
  }
  for (const std::uint32_t place : ordered.energies.of_point)
    program.power_ratios.push_back(*LaserSettingFor(laser, energies_mj[place]));
  return {};
}

/// The places of the axes, turning ones in degrees.
Result<post::PointProgram> ProgramOf(const OrderedJob& ordered) {
  const auto axes = KinematicsOf(ordered.job.machine())->axes();
  post::PointProgram program;
  program.name = ordered.job.job().name();
  INTAGLIO_TRY(SetPower(ordered, program));
  auto places =
      INTAGLIO_TRY(machine::AxesAlong(AxesFromGlassOf(ordered.job), ordered.path_mm,
                                      AxisLimitsOf(ordered.job.machine()).travel_mm));
  program.axes = std::move(places);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (axes[i].unit != machine::AxisUnit::kRad) continue;
    ++program.turning_count;
    for (Vec3& place : program.axes) {
      place[static_cast<int>(i)] *= 180 / std::numbers::pi;
    }
  }
  return program;
}

/// `--template`, else the one that the machine names.
Result<post::Template> TemplateOf(const PostOptions& options,
                                  const MachineSpec& machine) {
  if (!options.program_template.empty()) return ReadTemplate(options.program_template);
  if (!machine.post().empty()) return ReadTemplate(machine.post());
  return Fail(ErrorCode::kMissing,
              "--template: is missing, and the profile of " + machine.name() +
                  " has no field post; give a name of deploy/post or a file, here or in "
                  "the profile");
}

/// The contours of a job file that has a course.
Status MakeCourseProgram(const PostOptions& options, const JobSpec& job) {
  if (const auto errors = CheckCourse(job); !errors.empty())
    return tl::unexpected(JoinErrors(errors));
  if (options.program_template.empty()) {
    return Fail(ErrorCode::kMissing,
                "--template: is missing; give a name of deploy/post/mill, or a file");
  }
  const Course whole = WithDefaults(job.course());
  Warnings warnings;
  const auto made =
      ContoursFromFiles(whole, options.job.size_limits, Vec2(0, 0), warnings);
  PrintWarningLines(warnings);
  if (!made) return tl::unexpected(made.error());
  const ContourWork& work = made->work;
  ContourProgramOptions program;
  program.mill_template = options.program_template;
  program.out = options.out;
  Warnings of_programs;
  const auto written =
      INTAGLIO_TRY(WriteContourPrograms(work, whole, job.course(), program, of_programs));
  PrintWarningLines(of_programs);
  const std::vector<std::string> names(written.begin(), written.end());
  fmt::print(std::cout, "{} and {}: {} {}\n",
             client::GroupedCount(work.paths.size(), "contour"),
             client::GroupedCount(work.hole_count, "hole"),
             NounFor(names.size(), "program"), fmt::join(names, ", "));
  return {};
}

Status MakeProgram(const PostOptions& options) {
  if (options.path.empty()) {
    const auto job = INTAGLIO_TRY(FindCourseJob(options.job));
    if (job) return MakeCourseProgram(options, *job);
  }
  // First what takes no time.
  if (!options.program_template.empty()) {
    INTAGLIO_TRY(ReadTemplate(options.program_template));
  }
  const auto ordered =
      INTAGLIO_TRY(options.path.empty() ? OrderNamedJob(options) : TakePath(options));
  const auto program_template = INTAGLIO_TRY(TemplateOf(options, ordered.job.machine()));
  const auto program = INTAGLIO_TRY(ProgramOf(ordered));
  INTAGLIO_TRY(post::WritePointProgram(options.out, program_template, program));
  fmt::print(std::cout, "{} for {}, by {}, in {}\n",
             client::GroupedCount(program.axes.size(), "point"),
             ordered.job.machine().name(),
             fs::path(program_template.file).filename().string(), options.out);
  return {};
}

}  // namespace

void AddPostCommand(command_line::Command app) {
  auto options = std::make_shared<PostOptions>();
  command_line::Command post = app.AddCommand(
      "post", "write the program of a job for a controller of another maker");
  AddJobFlags(post, options->job);
  AddAnswers(post, options->accept);
  post.AddOption("--path", options->path,
                 "instead of models: points in the order of engraving, glass frame: " +
                     formats::PointExtensions());
  post.AddOption(
      "--template", options->program_template,
      "program template: a name in deploy/post (linuxcnc, linuxcnc-polar, "
      "grbl, isel, hpgl, sinumerik), of a job of contours one in deploy/post/mill, "
      "or a file; default the profile's post");
  post.AddOption("--out", options->out, "the program").Require();
  post.AddOption("--materials", options->materials_db,
                 "material base, default the user's");
  post.SetFooter(
      "The program moves the machine's axes to every point in the job's order, and fires "
      "one pulse there; it knows neither lamp nor interlocks. The program of a job with "
      "a course follows its contours.\n"
      "Example: intaglio post job.textproto --machine els-03 --template linuxcnc --out "
      "job.ngc\n"
      "Exit code: 0 written, 2 wrong input.");
  post.SetAction([options] {
    if (const Status taken = TakeAnswers(options->accept, options->job); !taken)
      return Complain(taken.error());
    const Status made = MakeProgram(*options);
    return made ? client::kExitGood : Complain(made.error());
  });
}

}  // namespace intaglio::cli
