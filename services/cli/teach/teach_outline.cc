#include "services/cli/teach/teach_outline.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "services/cli/flags/accept_flag.h"
#include "services/cli/job/job_glass.h"
#include "services/cli/preview/named_job.h"
#include "services/cli/teach/teach_options.h"
#include "services/cli/terminal/complain.h"
#include "services/cli/terminal/interrupt.h"
#include "services/client/exit_codes.h"
#include "services/client/teach/job_outline.h"
#include "services/job/marks/job_marks.h"
#include "services/job/models/job_cloud.h"
#include "services/job/models/program_limits.h"
#include "services/platform/host/threads/worker_threads.h"

namespace intaglio::cli {
namespace {

using client::TeachClient;
using client::TeachOrder;
using Clock = std::chrono::steady_clock;

// Ten times a second around a square of 50 mm.
constexpr double kGuideSpeedMmS = 2000;

struct OutlineOptions : TeachOptions {
  JobFlags job;
  AcceptFlag accept;
  ShopOfJob shop;
  std::string materials_db;
  double speed_mm_s = kGuideSpeedMmS;
  double time_s = 0;  ///< 0: until Ctrl-C
  bool rectangle = false;
};

Result<std::vector<Vec2>> OutlineOfMarks(const JobAndMachine& job) {
  if (job.job.marks().has_web()) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("{}: its marks are on a web, and have no place in the field "
                            "before the web runs: there is no outline of them",
                            job.job.name()),
                job.job.name());
  }
  const ReadLimits limits = mesh_reader::LimitsOfProgram(1);
  auto files = INTAGLIO_TRY(ReadJobMarkFiles(job.job, limits));
  Warnings warnings;
  const auto set = INTAGLIO_TRY(
      MakeJobMarks(job.job, job.machine, std::move(files), limits, warnings,
                   [](std::uint64_t, std::uint64_t) { return Interrupts() == 0; }));
  return client::OutlineOfMarks(set);
}

Result<std::vector<Vec2>> OutlineOfPoints(JobAndMachine& job,
                                          const std::string& materials_db) {
  const auto frozen = INTAGLIO_TRY(FreezeWithGlass(job, materials_db));
  const auto made =
      INTAGLIO_TRY(MakeJobCloud(frozen.job(), mesh_reader::LimitsOfProgram(1),
                                host::AllCores(), JobCloudProgress{}));
  return client::OutlineOfJob(frozen, made.cloud);
}

/// With the machine's own profile, which has what was taught, unless another is named.
Result<std::vector<Vec2>> CornersOf(const OutlineOptions& options,
                                    const client::MachineView& view) {
  JobFlags flags = options.job;
  INTAGLIO_TRY(TakeAnswers(options.accept, flags));
  if (!flags.machine) flags.machine = view.profile;
  auto job = INTAGLIO_TRY(FindNamedJob(flags, options.shop));
  if (job.job.has_course()) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("{}: follows contours; outlines are of jobs of points and of "
                            "marks",
                            job.job.name()),
                job.job.name());
  }
  auto corners =
      INTAGLIO_TRY(job.job.has_marks() ? OutlineOfMarks(job)
                                       : OutlineOfPoints(job, options.materials_db));
  return options.rectangle ? client::RectangleAround(corners) : std::move(corners);
}

TeachOrder OrderOf(const std::vector<Vec2>& corners, double speed_mm_s) {
  TeachOrder order;
  order.kind = intaglio_MANUAL_OUTLINE;
  order.speed_mm_s = speed_mm_s;
  for (const Vec2& corner : corners) {
    order.outline_x_mm.push_back(corner.x());
    order.outline_y_mm.push_back(corner.y());
  }
  return order;
}

std::string DrawnText(const std::vector<Vec2>& corners) {
  const std::vector<Vec2> around = client::RectangleAround(corners);
  const Vec2 size = around[2] - around[0];
  return fmt::format(
      "the guide laser draws {}, {:.1f} x {:.1f} mm, from x {:.1f}, y {:.1f}; "
      "Ctrl-C ends it",
      Counted(corners.size(), "corner"), size.x(), size.y(), around[0].x(),
      around[0].y());
}

/// Until the time is over, Ctrl-C, or an answer that ends it.
int Draw(TeachClient& client, const std::vector<Vec2>& corners,
         const OutlineOptions& options) {
  const TeachOrder order = OrderOf(corners, options.speed_mm_s);
  ReportWait wait(client);
  std::uint64_t number = client.Hold(order);
  const auto time = std::chrono::duration<double>(options.time_s);
  std::optional<Clock::time_point> since;
  while ((!client.IsAnswered(number) || wait.GivesAgain(order, number)) &&
         Interrupts() == 0) {
    client.Poll();
    if (!since && client.IsHeld(number)) {
      since = Clock::now();
      std::cout << DrawnText(corners) << "\n" << std::flush;
    }
    if (since && options.time_s > 0 && Clock::now() - *since > time) break;
    usleep(5000);
  }
  if (!client.IsAnswered(number)) {
    client.LetGo();
    return client::kExitGood;
  }
  return Complain(
      {ErrorCode::kRefused, client.view().cell + ": " + client.view().message, ""},
      client::kExitMachine);
}

}  // namespace

void AddOutlineCommand(command_line::Command teach) {
  auto options = std::make_shared<OutlineOptions>();
  command_line::Command command = teach.AddCommand(
      "outline",
      "draw the outline of a job with the guide laser while this command runs; no pulse "
      "is fired");
  command
      .AddOption("JOB|MODEL", options->job.what,
                 "a job file, the number of a job in a shop, or models")
      .Require();
  AddTeachFlags(command, *options);
  AddModelFlags(command, options->job);
  AddBlockFlags(command, options->job);
  AddPointFlags(command, options->job);
  AddMachineFlags(command, options->job);
  AddAnswers(command, options->accept);
  command.AddOption("--materials", options->materials_db,
                    "material base, default the user's");
  AddShopOfJob(command, options->shop);
  command.AddFlag("--rectangle", options->rectangle,
                  "the upright rectangle around the job, in place of its convex outline");
  command
      .AddOption("--speed", options->speed_mm_s,
                 "mm/s in the field; no faster than the machine jumps")
      .Within(1.0, 100000.0)
      .ShowDefault();
  command.AddOption("--for", options->time_s, "s, default until Ctrl-C")
      .Within(0.1, 3600.0);
  command.SetFooter(
      "Example: intaglio teach outline job.textproto\n"
      "The machine's own profile is used, unless --machine names another.");
  command.SetAction([options] {
    return WithMachine(*options, [&](TeachClient& client) -> int {
      const auto corners = CornersOf(*options, client.view());
      if (!corners) return Complain(corners.error());
      return Draw(client, *corners, *options);
    });
  });
}

}  // namespace intaglio::cli
