#include "services/cli/offline/offline_command.h"

#include <fmt/format.h>
#include <fmt/ostream.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>

#include "engrave/core/try.h"
#include "engrave/formats/point_file_kinds.h"
#include "engrave/proof/glass_comparison.h"
#include "engrave/render/png_file.h"
#include "engrave/render/views.h"
#include "proto/listing.pb.h"
#include "services/cli/flags/accept_flag.h"
#include "services/cli/flags/camera_flags.h"
#include "services/cli/flags/customer_picture_flags.h"
#include "services/cli/flags/size_limits_flag.h"
#include "services/cli/job/job_glass.h"
#include "services/cli/job/job_limits.h"
#include "services/cli/job/job_options.h"
#include "services/cli/json/print_json.h"
#include "services/cli/offline/offline_steps.h"
#include "services/cli/proofs/report_text.h"
#include "services/cli/terminal/complain.h"
#include "services/client/event_lines.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/client/proof/evidence/proof_figures.h"
#include "services/client/proof/evidence/proof_pictures.h"
#include "services/client/proof/evidence/verdict_text.h"
#include "services/client/proof/proof_folder.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct OfflineOptions {
  JobFlags job;
  AcceptFlag accept;
  std::string input, out, materials_db, glass_folder;
  std::vector<double> block_mm;
  std::vector<int> only;  // models, from 1; none: all
  bool json = false;
  bool renew = false;
  CustomerPictureFlags picture;
  CameraFlags camera;
};

/// Keeps the points of these models, numbered from 1; of none given all.
Status KeepModels(const std::vector<int>& only, int model_count, PointCloud& cloud) {
  if (only.empty()) return {};
  for (const int model : only) {
    if (model >= 1 && model <= model_count) continue;
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("--only: there is no model {}; the job has models 1 to {}",
                            model, model_count),
                std::to_string(model));
  }
  PointCloud kept;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const int model = static_cast<int>(cloud.source[i]) + 1;
    if (std::ranges::find(only, model) == only.end()) continue;
    kept.Add(cloud.points_mm[i], cloud.source[i]);
  }
  if (kept.size() == 0) {
    return Fail(ErrorCode::kMissing,
                fmt::format("--only: model {} has no points of its own in the cloud",
                            fmt::join(only, ", ")));
  }
  cloud = std::move(kept);
  return {};
}

CloudRecord CloudRecordOf(const std::string& file, const JobCloud& made) {
  CloudRecord record;
  record.set_file(file);
  record.set_point_count(static_cast<std::uint32_t>(made.cloud.size()));
  const double spacing_mm = proof::MinSpacing(made.cloud.points_mm);
  if (std::isfinite(spacing_mm)) record.set_min_spacing_mm(spacing_mm);
  record.set_checksum(client::PointChecksum(made.cloud.points_mm));
  AddTo(*record.mutable_warnings(), made.warnings);
  return record;
}

int DiscretizeOffline(const OfflineOptions& given) {
  OfflineOptions options = given;
  if (const auto taken = TakeAnswers(options.accept, options.job); !taken)
    return Complain(taken.error());
  auto job = BuildJob(options.job);
  if (!job) return Complain(job.error(), client::kExitWrongInput);
  // The cloud does not depend on the glass; the job that it is made for does.
  if (const auto glass = FindGlass(*job, options.materials_db); !glass) {
    return Complain(glass.error(), client::kExitWrongInput);
  }
  auto cloud = MakeMeteredCloud(job->job, LimitsOf(options.job));
  if (!cloud) return Complain(cloud.error(), client::kExitWrongInput);
  if (auto kept = KeepModels(options.only, job->job.models_size(), cloud->cloud); !kept) {
    return Complain(kept.error(), client::kExitWrongInput);
  }
  formats::PointTable table;
  table.points_mm = cloud->cloud.points_mm;
  table.columns = {{"source", cloud->cloud.source}};
  if (auto written = WritePoints(options.out, table); !written) {
    return Complain(written.error(), client::kExitWrongInput);
  }
  PrintWarningLines(cloud->warnings);
  const CloudRecord record = CloudRecordOf(options.out, *cloud);
  if (options.json) return PrintJson(record);
  fmt::print(std::cout, "{}, minimum spacing {:.4f} mm, checksum {}, in {}\n",
             client::GroupedCount(record.point_count(), "point"), record.min_spacing_mm(),
             record.checksum(), record.file());
  return client::kExitGood;
}

/// What the folder is completed with, but what could not be written.
int PrintProof(const OfflineOptions& options, const client::ProvedFolder& proved) {
  const auto text = options.json ? client::JsonOf(proved.report)
                                 : Result<std::string>(SummaryOf(proved.report));
  if (!text) return Complain(text.error(), client::kExitInternal);
  std::cout << *text << "\n";
  if (proved.not_written) {
    return Complain(*proved.not_written, client::kExitWrongInput);
  }
  return client::ExitCodeOf(client::KindOf(proved.report.verdict()));
}

/// The customer's picture, too, where it is asked for and everything else is written.
Result<client::ProvedFolder> Complete(const OfflineOptions& options,
                                      const fs::path& folder) {
  auto proved = client::CompleteFolder({folder, options.glass_folder, options.renew});
  if (!proved || proved->not_written || !options.picture.asked()) return proved;
  const auto* evidence = std::get_if<client::Evidence>(&proved->evidence);
  if (evidence == nullptr) return proved;  // a piece with marks has none
  const auto drawn = client::WriteCustomerPicture(options.picture.FileIn(folder),
                                                  *evidence, options.picture.Picture());
  if (!drawn) proved->not_written = drawn.error();
  return proved;
}

/// One line for each job whose folder was not complete. Exit code: of the worst.
int CompleteJobs(const OfflineOptions& options, const std::vector<fs::path>& folders) {
  int worst = client::kExitGood;
  for (const fs::path& folder : folders) {
    const bool is_complete = fs::exists(folder / client::kReportFile) &&
                             fs::exists(folder / client::kViewsFile) &&
                             (!options.picture.asked() || client::HasMarks(folder) ||
                              fs::exists(options.picture.FileIn(folder)));
    if (is_complete && !options.renew) continue;
    const auto proved = Complete(options, folder);
    if (!proved || proved->not_written) {
      worst = Complain(proved ? *proved->not_written : proved.error(),
                       client::kExitWrongInput);
      continue;
    }
    std::cout << folder.string() << "  "
              << client::VerdictTitle(proved->report.verdict(), "GOOD") << "\n";
    if (worst == client::kExitGood)
      worst = client::ExitCodeOf(client::KindOf(proved->report.verdict()));
  }
  return worst;
}

int VerifyOffline(const OfflineOptions& options) {
  const auto folders = client::JobFoldersIn(options.input);
  if (!folders.empty()) return CompleteJobs(options, folders);
  const auto proved = Complete(options, options.input);
  if (!proved) return Complain(proved.error(), client::kExitWrongInput);
  const bool drawn = options.picture.asked() && !client::HasMarks(options.input);
  if (drawn && !proved->not_written && !options.json)
    std::cout << "picture     " << options.picture.FileIn(options.input).string() << "\n";
  return PrintProof(options, *proved);
}

std::string SizeText(const Vec3& size_mm) {
  return fmt::format("{:.4g} x {:.4g} x {:.4g} mm", size_mm.x(), size_mm.y(),
                     size_mm.z());
}

int RenderOffline(const OfflineOptions& options) {
  const auto table = ReadPoints(options.input);
  if (!table) return Complain(table.error(), client::kExitWrongInput);
  Box3 box;
  for (const Vec3& p : table->points_mm) box.Extend(p);
  const Vec3 block =
      options.block_mm.empty()
          ? Vec3((box.max_mm.array() + box.min_mm.array().max(1)).matrix())
          : Vec3(options.block_mm[0], options.block_mm[1], options.block_mm[2]);
  render::ViewsCaption caption;
  caption.title_lines = {fs::path(options.input).filename().string()};
  caption.figures = {
      {"points", client::GroupedDigits(table->points_mm.size())},
      {"minimum spacing", fmt::format("{:.4f} mm", proof::MinSpacing(table->points_mm))},
      {"object", SizeText(box.size_mm())}};
  const auto written = render::WritePng(
      options.out,
      render::RenderViews(table->points_mm, block, caption, options.camera.Views()));
  if (!written) return Complain(written.error(), client::kExitWrongInput);
  std::cout << "picture in " << options.out << "\n";
  if (options.picture.asked()) {
    const fs::path file = options.picture.FileIn(fs::path(options.out).parent_path());
    const auto drawn = render::WriteCustomerPicture(file, table->points_mm, block,
                                                    options.picture.Picture());
    if (!drawn) return Complain(drawn.error(), client::kExitWrongInput);
    std::cout << "customer's picture in " << file.string() << "\n";
  }
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
  // The points do not depend on the job's name: a {column} in it needs no value here.
  options->job.name = "cloud";
  AddWhat(discretize, options->job);
  AddModelFlags(discretize, options->job);
  AddTextFlags(discretize, options->job.texts);
  AddBlockFlags(discretize, options->job);
  AddPointFlags(discretize, options->job);
  AddMachineFlags(discretize, options->job);
  AddSetFlag(discretize, options->job);
  AddAnswers(discretize, options->accept);
  discretize.AddOption("--only", options->only,
                       "write only the points of these models, numbered from 1; the "
                       "others still take their place");
  AddSizeLimitsFlag(discretize, options->job.size_limits);
  discretize.AddOption("--out", options->out, "cloud: " + formats::PointExtensions())
      .Require();
  discretize.AddOption("--materials", options->materials_db,
                       "material base, default the user's");
  discretize.AddFlag("--json", options->json, "the figures for programs");
  discretize.SetFooter(
      "Example: intaglio discretize bunny.obj --height 40 --spacing 0.1 --out "
      "cloud.ply");
  discretize.SetAction(with_options(DiscretizeOffline));

  command_line::Command verify = app.AddCommand(
      "verify", "check a finished folder again, and complete its report and pictures");
  verify
      .AddOption(
          "FOLDER", options->input,
          "a folder of `intaglio run`, or of a job in a shop's folder jobs; or this "
          "folder jobs itself, of which the incomplete ones are completed")
      .Require();
  verify.AddFlag("--json", options->json, "for programs, as report.json");
  verify.AddFlag("--renew", options->renew,
                 "make report and pictures anew that are there already");
  verify.AddOption("--glass", options->glass_folder,
                   "folder with the records of a virtual engraver or scan head, default "
                   "that of the job's shop");
  AddCustomerPictureFlags(verify, options->picture);
  verify.SetFooter(
      "Example: intaglio verify intaglio-shop/jobs/1-2b6f --customer-picture\n"
      "Exit code: 0 good, 2 not a finished folder, or it cannot be written, 3 not good.");
  verify.SetAction(with_options(VerifyOffline));

  command_line::Command render =
      app.AddCommand("render", "make a picture of a cloud of points");
  render.AddOption("CLOUD", options->input, "points: " + formats::PointExtensions())
      .Require();
  render.AddOption("--block", options->block_mm, "block size x y z, mm").TakeValues(3);
  render.AddOption("--out", options->out, "picture.png").Require();
  AddCameraFlags(render, options->camera);
  AddCustomerPictureFlags(render, options->picture);
  render.SetFooter(
      "Example: intaglio render cloud.ply --block 50 50 50 --out picture.png");
  render.SetAction(with_options(RenderOffline));
}

}  // namespace intaglio::cli
