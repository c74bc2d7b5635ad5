#include "services/cli/offline/plan_command.h"

#include <iostream>
#include <memory>
#include <optional>

#include "engrave/core/try.h"
#include "engrave/formats/point_file_kinds.h"
#include "services/cli/flags/size_limits_flag.h"
#include "services/cli/offline/offline_steps.h"
#include "services/cli/offline/path_figures.h"
#include "services/cli/offline/path_job.h"
#include "services/cli/offline/segment_file.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/job/convert/options.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/models/read_limits.h"
#include "services/job/plan/ordering.h"
#include "services/job/plan/point_order.h"

namespace intaglio::cli {
namespace {

struct PathOptions {
  JobFlags job;
  std::string input, out, csv, materials_db;
  std::string frame = "glass", out_frame;
  bool compare = false;
  bool json = false;
};

/// A path as points of the glass and as axes of the machine.
struct Path {
  PointList glass_mm, axes;
};

Result<PointList> ReadPath(const PathOptions& options, const std::string& flag) {
  const ReadLimits limits = ReadLimitsTimes(options.job.size_limits);
  auto table = ReadPoints(options.input, limits.points);
  if (!table) {
    Error error = WithRemedy(table.error(), limits);
    error.message = flag + ": " + error.message;
    return tl::unexpected(std::move(error));
  }
  return std::move(table->points_mm);
}

Result<Path> InBothFrames(const FrozenJob& job, PointList points, bool of_machine) {
  const machine::AxesFromGlass axes_from_glass = AxesFromGlassOf(job);
  Path path;
  if (of_machine) {
    path.glass_mm.reserve(points.size());
    for (const Vec3& axes : points)
      path.glass_mm.push_back(axes_from_glass.ToGlass(axes));
    path.axes = std::move(points);
    return path;
  }
  auto axes = INTAGLIO_TRY(
      machine::AxesAlong(axes_from_glass, points, AxisLimitsOf(job.machine()).travel_mm));
  path.axes = std::move(axes);
  path.glass_mm = std::move(points);
  return path;
}

/// What is known of each point of a planned path.
struct PointFigures {
  std::vector<double> ticks;
  std::vector<double> errors_um;  ///< predicted; empty: not
};

/// The job's own motion: its segments to the file of `--csv`, and the points' figures.
Result<PlannedMotion> PlanOwn(const PathOptions& options, const FrozenJob& job,
                              const PointList& path, PointFigures& figures) {
  std::optional<SegmentFile> file;
  if (!options.csv.empty()) {
    auto created = INTAGLIO_TRY(SegmentFile::Create(
        options.csv, KinematicsOf(job.machine())->axes(), path.front()));
    file.emplace(std::move(created));
  }
  figures.ticks.assign(path.size(), 0);
  std::uint64_t subticks = 0;
  const SegmentSink sink = [&](const motion::Segment& segment) -> Status {
    subticks += segment.duration_subticks;
    if (segment.point >= 0) {
      figures.ticks.at(static_cast<std::size_t>(segment.point)) =
          static_cast<double>(subticks / motion::kSubticksPerTick);
    }
    return file ? file->Append(segment) : Status{};
  };
  Meter meter("plan");
  auto planned = PlanMotion(job, path, sink, meter.Sink(), &figures.errors_um);
  if (!planned || !file) return planned;
  INTAGLIO_TRY(file->Commit());
  return planned;
}

/// The path for `--out`, with the figures of each point.
Status WritePath(const PathOptions& options, Path path, PointFigures figures) {
  const std::string& frame =
      options.out_frame.empty() ? options.frame : options.out_frame;
  const bool of_machine = frame == "machine";
  formats::PointTable table;
  table.points_mm = std::move(of_machine ? path.axes : path.glass_mm);
  table.columns = {{"tick", std::move(figures.ticks)}};
  if (!figures.errors_um.empty()) {
    table.columns.push_back({"predicted_error_um", std::move(figures.errors_um)});
  }
  return WritePoints(options.out, table);
}

Status PlanOthers(const FrozenJob& job, const PointList& path, PlanReport& report) {
  for (const FrozenJob& other : WithOtherPlanners(job)) {
    Meter meter(ProfileName(other.job().motion().profile()));
    auto planned = INTAGLIO_TRY(PlanMotion(other, path, {}, meter.Sink()));
    *report.add_motions() = std::move(planned);
  }
  return {};
}

/// Prints the report; the code that the command ends with.
int Print(const PathOptions& options, const PlanReport& report) {
  std::cout << (options.json ? JsonOf(report) : FiguresOf(report)) << "\n";
  if (options.compare && !options.json) {
    std::cout << "\n" << ComparisonOf(report) << "\n";
  }
  return IsSound(report) ? client::kExitGood : client::kExitNotGood;
}

int Sort(const PathOptions& options) {
  auto cloud_mm = ReadPath(options, "--cloud");
  if (!cloud_mm) return Complain(cloud_mm.error(), client::kExitWrongInput);
  auto job = BuildPathJob(options.job, *cloud_mm, options.materials_db);
  if (!job) return Complain(job.error(), client::kExitWrongInput);
  // An order does not depend on where the cloud lies; one without a block is ordered too.
  if (!RequireInBlock(*job, *cloud_mm)) ForgetTravel(*job->mutable_machine());
  formats::PointTable table;
  {
    Meter meter("order");
    const auto order =
        OrderPoints(*job, *cloud_mm, std::vector<ChannelMask>(cloud_mm->size(), 1),
                    host::OrderingOf(*job), meter.Sink());
    if (!order) return Complain(order.error(), client::kExitWrongInput);
    table.points_mm.reserve(order->size());
    for (const std::uint32_t i : *order) table.points_mm.push_back((*cloud_mm)[i]);
  }
  if (auto written = WritePoints(options.out, table); !written) {
    return Complain(written.error(), client::kExitWrongInput);
  }
  PlanReport report = DescribePath(*job, table.points_mm);
  const auto path = InBothFrames(*job, std::move(table.points_mm), false);
  if (!path) return Complain(path.error(), client::kExitWrongInput);
  PointFigures figures;
  auto planned = PlanOwn(options, *job, path->axes, figures);
  if (!planned) return Complain(planned.error(), client::kExitWrongInput);
  *report.add_motions() = std::move(*planned);
  return Print(options, report);
}

int Plan(const PathOptions& options) {
  auto points_mm = ReadPath(options, "--path");
  if (!points_mm) return Complain(points_mm.error(), client::kExitWrongInput);
  auto job = BuildPathJob(options.job, *points_mm, options.materials_db);
  if (!job) return Complain(job.error(), client::kExitWrongInput);
  const bool of_machine = options.frame == "machine";
  if (of_machine) {
    ForgetTravel(*job->mutable_machine());
  } else {
    if (auto in_block = RequireInBlock(*job, *points_mm); !in_block) {
      return Complain(in_block.error(), client::kExitWrongInput);
    }
  }
  auto path = InBothFrames(*job, std::move(*points_mm), of_machine);
  if (!path) return Complain(path.error(), client::kExitWrongInput);
  PlanReport report = DescribePath(*job, path->glass_mm);
  PointFigures figures;
  auto planned = PlanOwn(options, *job, path->axes, figures);
  if (!planned) return Complain(planned.error(), client::kExitWrongInput);
  *report.add_motions() = std::move(*planned);
  if (options.compare) {
    if (auto others = PlanOthers(*job, path->axes, report); !others) {
      return Complain(others.error(), client::kExitWrongInput);
    }
  }
  if (!options.out.empty()) {
    if (auto written = WritePath(options, std::move(*path), std::move(figures));
        !written) {
      return Complain(written.error(), client::kExitWrongInput);
    }
  }
  return Print(options, report);
}

/// Those of a job whose points are there: in its block, moved to by its machine.
void AddPathJobFlags(command_line::Command command, JobFlags& flags) {
  AddJobFile(command, flags);
  AddBlockFlag(command, flags);
  AddMotionFlags(command, flags);
  AddMachineFlags(command, flags);
  AddSetFlag(command, flags);
  AddSizeLimitsFlag(command, flags.size_limits);
}

void AddSort(command_line::Command app) {
  auto options = std::make_shared<PathOptions>();
  command_line::Command sort =
      app.AddCommand("sort", "put a cloud of points into the order of engraving");
  sort.AddOption("--cloud", options->input, "points: " + formats::PointExtensions())
      .Require();
  sort.AddOption("--out", options->out, "path: " + formats::PointExtensions()).Require();
  sort.AddOption("--csv", options->csv, "the motion's segments, one row for each knot");
  sort.AddFlag("--json", options->json, "the figures for programs");
  sort.AddOption("--materials", options->materials_db,
                 "material base, default the user's");
  AddPathJobFlags(sort, options->job);
  AddSpacingFlag(sort, options->job);
  AddOrderFlags(sort, options->job);
  sort.SetFooter(
      "Of a job file the block, the machine, the glass, the lens, the order and the "
      "motion are used.\n"
      "Example: intaglio sort --cloud cloud.ply --block 50 50 50 --out path.ply\n"
      "Exit code: 0 good, 2 wrong input, 3 a violation of the order or of the motion.");
  sort.SetAction([options] { return Sort(*options); });
}

void AddPlan(command_line::Command app) {
  auto options = std::make_shared<PathOptions>();
  command_line::Command plan =
      app.AddCommand("plan", "plan the motion along a path and print its figures");
  plan.AddOption("--path", options->input,
                 "points in the order of engraving: " + formats::PointExtensions())
      .Require();
  plan.AddOption("--frame", options->frame,
                 "glass (default): the points lie in the block; machine: they are "
                 "places of the stage, the machine's axes, from a zero of their own")
      .OneOf({"glass", "machine"});
  plan.AddOption("--out-frame", options->out_frame,
                 "of --out, that of the path when not given; machine: where the axes are")
      .OneOf({"glass", "machine"});
  plan.AddOption("--csv", options->csv, "the motion's segments, one row for each knot");
  plan.AddOption(
      "--out", options->out,
      "copy of the path; .ply and .scl have the tick of each point and how far "
      "from it the profile's drive will be");
  plan.AddFlag("--compare", options->compare, "a table of all planners");
  plan.AddFlag("--json", options->json, "the figures for programs");
  plan.AddOption("--materials", options->materials_db,
                 "material base, default the user's");
  AddPathJobFlags(plan, options->job);
  plan.SetFooter(
      "Of a job file the block, the machine, the glass, the lens and the motion are "
      "used.\n"
      "Example: intaglio plan --path path.ply --rate 100 --csv segments.csv --compare\n"
      "Exit code: 0 good, 2 wrong input, 3 a violation of the order or of the motion.");
  plan.SetAction([options] { return Plan(*options); });
}

}  // namespace

void AddPathCommands(command_line::Command app) {
  AddSort(app);
  AddPlan(app);
}

}  // namespace intaglio::cli
