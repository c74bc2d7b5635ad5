#include "services/cli/offline/offline_command.h"

#include <fmt/format.h>

#include <iostream>
#include <memory>

#include "engrave/core/try.h"
#include "engrave/discretize/cloud.h"
#include "engrave/formats/point_file_kinds.h"
#include "engrave/proof/glass_comparison.h"
#include "engrave/render/png_file.h"
#include "engrave/render/views.h"
#include "services/cli/complain.h"
#include "services/cli/job_options.h"
#include "services/cli/offline/offline_steps.h"
#include "services/cli/report_text.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/client/proof_folder.h"
#include "services/job/models/discretize_outcome.h"
#include "services/job/models/model_sources.h"
#include "services/job/models/program_limits.h"
#include "services/platform/host/threads/worker_threads.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct OfflineOptions {
  JobFlags job;
  std::string input, out;
  std::vector<double> block_mm;
  bool json = false;
};

/// The job's points, made here in one process.
Result<discretize::Discretized> MakePoints(const JobSpec& job, const ReadLimits& limits) {
  auto files = INTAGLIO_TRY(ReadFilesOf(job, limits));
  Meter meter("discretize", Meter::Of::kShares);
  auto sources = INTAGLIO_TRY(MakeSources(job, std::move(files), limits, meter.Sink()));
  auto made = discretize::MakeCloud(sources.sources, CloudOptionsOf(job), {},
                                    host::AllCores(), meter.Sink());
  if (!made) return made;
  if (made->cloud.size() == 0) return tl::unexpected(discretize::NoPoints());
  for (const std::string& warning : WarningsOf(OutcomeOf(sources, *made, {}), job)) {
    std::cerr << "warning    " << warning << "\n";
  }
  return made;
}

int DiscretizeOffline(const OfflineOptions& options) {
  const auto job = BuildJob(options.job);
  if (!job) return Complain(job.error(), client::kExitWrongInput);
  const auto cloud =
      MakePoints(job->job, mesh_reader::LimitsOfProgram(options.job.size_limits));
  if (!cloud) return Complain(cloud.error(), client::kExitWrongInput);
  formats::PointTable table;
  table.points_mm = cloud->cloud.points_mm;
  table.columns = {{"source", cloud->cloud.source}};
  if (auto written = WritePoints(options.out, table); !written) {
    return Complain(written.error(), client::kExitWrongInput);
  }
  std::cout << client::GroupedDigits(table.points_mm.size())
            << " points, minimum spacing "
            << fmt::format("{:.4f} mm", proof::MinSpacing(table.points_mm))
            << ", checksum " << client::PointChecksum(table.points_mm) << ", in "
            << options.out << "\n";
  return client::kExitGood;
}

int VerifyOffline(const OfflineOptions& options) {
  const auto report = client::VerifyFolder(options.input);
  if (!report) return Complain(report.error(), client::kExitWrongInput);
  const auto text =
      options.json ? client::JsonOf(*report) : Result<std::string>(SummaryOf(*report));
  if (!text) return Complain(text.error(), client::kExitInternal);
  std::cout << *text << "\n";
  return report->verdict().good() ? client::kExitGood : client::kExitNotGood;
}

int RenderOffline(const OfflineOptions& options) {
  const auto table = ReadPoints(options.input);
  if (!table) return Complain(table.error(), client::kExitWrongInput);
  Box3 box;
  for (const Vec3& p : table->points_mm) box.Extend(p);
  if (box.empty()) {
    return Complain({ErrorCode::kMissing, options.input + " has no points", ""},
                    client::kExitWrongInput);
  }
  const Vec3 block =
      options.block_mm.empty()
          ? Vec3((box.max_mm.array() + box.min_mm.array().max(1)).matrix())
          : Vec3(options.block_mm[0], options.block_mm[1], options.block_mm[2]);
  render::ViewsCaption caption;
  caption.title_lines = {fs::path(options.input).filename().string()};
  caption.figures = {
      {"points", client::GroupedDigits(table->points_mm.size())},
      {"minimum spacing", fmt::format("{:.4f} mm", proof::MinSpacing(table->points_mm))}};
  const auto written = render::WritePng(
      options.out, render::RenderViews(table->points_mm, block, caption));
  if (!written) return Complain(written.error(), client::kExitWrongInput);
  std::cout << "picture in " << options.out << "\n";
  return client::kExitGood;
}

}  // namespace

void AddOfflineCommands(command_line::Command app) {
  auto options = std::make_shared<OfflineOptions>();
  const auto with_options = [options](int (*act)(const OfflineOptions&)) {
    return [options, act] { return act(*options); };
  };
  command_line::Command discretize =
      app.AddCommand("discretize", "make a cloud of points from models");
  AddJobFlags(discretize, options->job);
  discretize
      .AddOption("--out", options->out, "cloud: " + formats::WritablePointExtensions())
      .Require();
  discretize.SetFooter(
      "Example: intaglio discretize --mesh bunny.obj --height 40 --spacing 0.1 --out "
      "cloud.ply");
  discretize.SetAction(with_options(DiscretizeOffline));

  command_line::Command verify =
      app.AddCommand("verify", "check a finished folder again");
  verify.AddOption("FOLDER", options->input, "a folder written by `intaglio run`")
      .Require();
  verify.AddFlag("--json", options->json, "for programs, as report.json");
  verify.SetFooter(
      "Example: intaglio verify intaglio-out/bunny\n"
      "Exit code: 0 good, 2 not a finished folder, 3 not good.");
  verify.SetAction(with_options(VerifyOffline));

  command_line::Command render =
      app.AddCommand("render", "make a picture of a cloud of points");
  render
      .AddOption("CLOUD", options->input, "points: " + formats::ReadablePointExtensions())
      .Require();
  render.AddOption("--block", options->block_mm, "block size x y z, mm").TakeValues(3);
  render.AddOption("--out", options->out, "picture.png").Require();
  render.SetFooter(
      "Example: intaglio render cloud.ply --block 50 50 50 --out picture.png");
  render.SetAction(with_options(RenderOffline));
}

}  // namespace intaglio::cli
