#include "services/cli/offline/measure_command.h"

#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <optional>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/mesh/mesh.h"
#include "engrave/proof/cloud_quality.h"
#include "engrave/render/png_file.h"
#include "engrave/render/spacing_map.h"
#include "services/cli/flags/accept_flag.h"
#include "services/cli/flags/size_limits_flag.h"
#include "services/cli/job/job_limits.h"
#include "services/cli/job/job_options.h"
#include "services/cli/offline/offline_steps.h"
#include "services/cli/offline/quality_figures.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/job/convert/model_kind.h"
#include "services/job/fields/channels.h"
#include "services/job/models/model_sources.h"
#include "services/job/models/read_limits.h"
#include "services/job/quality/quality_options.h"
#include "services/job/verdict/warnings.h"
#include "services/platform/host/threads/worker_threads.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

// Copies of a model multiply its triangles.
constexpr std::size_t kMaxTriangles = 50'000'000;

struct MeasureOptions {
  JobFlags job;
  AcceptFlag accept;
  std::string cloud, picture;
  std::optional<double> height_ratio;
  std::optional<std::uint32_t> channel;
  bool json = false, csv = false;
};

void Append(const mesh::TriangleMesh& one, const Vec3& offset_mm,
            mesh::TriangleMesh& all) {
  const auto first = static_cast<std::uint32_t>(all.vertices.size());
  for (const Vec3& v : one.vertices) all.vertices.push_back(v + offset_mm);
  for (const auto& [a, b, c] : one.triangles) {
    all.triangles.push_back({first + a, first + b, first + c});
  }
}

Result<mesh::TriangleMesh> WithCopies(const Model& model, const Block& block,
                                      mesh::TriangleMesh one) {
  if (!model.has_copies()) return one;
  const PointList offsets_mm = CopyOffsetsOf(model, block);
  if (offsets_mm.size() * one.triangles.size() > kMaxTriangles) {
    return Fail(
        ErrorCode::kTooLarge,
        fmt::format("{}: {} of {} {} the {} triangles allowed; measure fewer copies",
                    model.file(), Counted(offsets_mm.size(), "copy", "copies"),
                    Counted(one.triangles.size(), "triangle"),
                    VerbFor(offsets_mm.size(), "exceeds", "exceed"), kMaxTriangles));
  }
  mesh::TriangleMesh all;
  for (const Vec3& offset_mm : offsets_mm) Append(one, offset_mm, all);
  return all;
}

/// The surfaces of the job's models in the block; of those that are no meshes or not of
/// the channel, without triangles. None when there is no mesh. What is not read of their
/// files is added to `warnings`.
Result<std::vector<mesh::TriangleMesh>> SurfacesOf(const MeasureOptions& options,
                                                   const JobSpec& job,
                                                   Warnings& warnings) {
  const ReadLimits limits = LimitsOf(options.job);
  const std::vector<ChannelMask> masks = ChannelsOfModels(job);
  std::vector<mesh::TriangleMesh> surfaces(static_cast<std::size_t>(job.models_size()));
  bool any = false;
  for (int i = 0; i < job.models_size(); ++i) {
    const Model& model = job.models(i);
    const auto kind = KindOf(model);
    if (!kind) {
      return Fail(kind.error().code, model.file() + " " + kind.error().message);
    }
    if (*kind != ModelKind::kMesh) continue;
    if (options.channel && !ShareChannel(masks[static_cast<std::size_t>(i)],
                                         MaskOfChannel(*options.channel))) {
      continue;
    }
    auto placed = INTAGLIO_TRY(PlacedMeshOf(job, model, limits, warnings));
    auto copied = INTAGLIO_TRY(WithCopies(model, job.block(), std::move(placed)));
    any = any || !copied.triangles.empty();
    surfaces[static_cast<std::size_t>(i)] = std::move(copied);
  }
  if (!any) surfaces.clear();
  return surfaces;
}

struct MeasuredCloud {
  PointCloud cloud;
  std::vector<ChannelMask> masks;  ///< of cracks, the channel that each is in
};

Result<MeasuredCloud> ReadCloud(const std::string& file, const ReadLimits& limits) {
  auto table = ReadPoints(file, limits.points);
  if (!table) return tl::unexpected(WithRemedy(table.error(), limits));
  MeasuredCloud read;
  if (const auto* sources = table->Find<std::uint32_t>("source")) {
    read.cloud.source = *sources;
  }
  if (const auto* channels = table->Find<std::uint8_t>("channel")) {
    for (const std::uint8_t channel : *channels) {
      read.masks.push_back(MaskOfChannel(channel % kMaxChannels + 1));
    }
  }
  read.cloud.points_mm = std::move(table->points_mm);
  read.cloud.source.resize(read.cloud.points_mm.size(), 0);
  return read;
}

/// Description of the block of one channel: of cracks read from the file, of points from
/// their models.
Result<PointCloud> InChannel(const MeasureOptions& options, const JobSpec& job,
                             MeasuredCloud read) {
  if (read.masks.empty()) {
    auto masks = INTAGLIO_TRY(ChannelsOfPoints(job, read.cloud.source));
    read.masks = std::move(masks);
  }
  if (!options.channel) {
    if (DistinctMasks(read.masks).size() == 1) return std::move(read.cloud);
    return Fail(ErrorCode::kMissing,
                "--channel: is missing; the points are in different blocks, give the "
                "channel to measure");
  }
  PointCloud in_channel =
      PointsIn(MaskOfChannel(*options.channel), read.cloud, read.masks);
  if (in_channel.size() == 0) {
    return Fail(ErrorCode::kMissing,
                fmt::format("--channel: {} has no points", *options.channel));
  }
  return in_channel;
}

proof::QualityOptions OptionsOf(const MeasureOptions& options, const JobAndMachine& job) {
  proof::QualityOptions quality = QualityOptionsOf(job.job, job.machine);
  quality.height_ratio = options.height_ratio.value_or(quality.height_ratio);
  quality.executor = host::AllCores();
  return quality;
}

render::ViewsCaption CaptionOf(const MeasureOptions& options,
                               const CloudQuality& record) {
  using render::Tone;
  const NearestDistanceFigures& nearest = record.nearest();
  render::ViewsCaption caption;
  caption.title_lines = {
      fs::path(options.cloud).filename().string(),
      fmt::format("{}; distance to the nearest other point, compared with the "
                  "minimum spacing of {:g} mm",
                  client::GroupedCount(record.point_count(), "point"),
                  record.min_spacing_mm())};
  auto& figures = caption.figures;
  figures = {{"least",
              record.has_nearest() ? fmt::format("{:.4f} mm", nearest.min_mm())
                                   : "none: one point",
              record.keeps_spacing() ? Tone::kGood : Tone::kBad},
             {"mean", fmt::format("{:.4f} mm", nearest.mean_mm())},
             {"varies by", fmt::format("{:.1f} %", 100 * nearest.variation_ratio())},
             {"pairs too near", client::GroupedDigits(nearest.near_pair_count()),
              nearest.near_pair_count() == 0 ? Tone::kGood : Tone::kBad}};
  if (record.has_surface()) {
    const SurfaceFigures& surface = record.surface();
    figures.push_back({"largest uncovered disc",
                       fmt::format("{:.3f} mm", surface.uncovered_radius_mm())});
    figures.push_back({"maximum distance off surface",
                       fmt::format("{:.2f} µm", 1000 * surface.greatest_distance_mm())});
    figures.push_back({"density", fmt::format("{:.1f} /mm²", surface.points_per_mm2())});
    figures.push_back(
        {"density varies by", fmt::format("{:.1f} %", 100 * surface.variation_ratio())});
  }
  if (record.has_cracks()) {
    figures.push_back(
        {"cracks of the volume, at most",
         fmt::format("{:.0f} %", 100 * record.cracks().densest().crack_share_ratio()),
         record.cracks().risky_count() == 0 ? Tone::kGood : Tone::kBad});
  }
  caption.verdict = record.keeps_spacing() ? "SPACING KEPT" : "TOO NEAR";
  caption.verdict_tone = record.keeps_spacing() ? Tone::kGood : Tone::kBad;
  return caption;
}

Status DrawPicture(const MeasureOptions& options, const PointList& points_mm,
                   const proof::CloudQuality& quality, const CloudQuality& record) {
  return render::WritePng(
      options.picture,
      render::RenderSpacingMap(
          {points_mm, quality.nearest.distance_mm, record.min_spacing_mm(),
           quality.histogram.bin_mm, quality.histogram.counts},
          CaptionOf(options, record)));
}

int Measure(const MeasureOptions& given) {
  MeasureOptions options = given;
  if (const auto taken = TakeAnswers(options.accept, options.job); !taken)
    return Complain(taken.error());
  auto all = ReadCloud(options.cloud, ReadLimitsTimes(options.job.size_limits));
  if (!all) return Complain(all.error(), client::kExitWrongInput);
  const auto job = BuildJobOfPoints(options.job, all->cloud.points_mm);
  if (!job) return Complain(job.error(), client::kExitWrongInput);
  auto cloud = InChannel(options, job->job, std::move(*all));
  if (!cloud) return Complain(cloud.error(), client::kExitWrongInput);
  Warnings warnings;
  auto surfaces = SurfacesOf(options, job->job, warnings);
  if (!surfaces) return Complain(surfaces.error(), client::kExitWrongInput);
  const proof::QualityOptions quality_options = OptionsOf(options, *job);
  const auto quality = proof::MeasureCloud(*cloud, *surfaces, quality_options);
  if (!quality) return Complain(quality.error(), client::kExitWrongInput);
  surfaces->clear();
  CloudQuality record = RecordOf(*quality, quality_options);
  AddTo(*record.mutable_warnings(), warnings);
  if (!options.picture.empty()) {
    const auto drawn = DrawPicture(options, cloud->points_mm, *quality, record);
    if (!drawn) return Complain(drawn.error(), client::kExitWrongInput);
  }
  std::cout << (options.json  ? JsonOf(record)
                : options.csv ? CsvOf(record)
                              : FiguresOf(record))
            << (options.csv && !options.json ? "" : "\n");
  return record.keeps_spacing() ? client::kExitGood : client::kExitNotGood;
}

/// Those of a job that place its models and name its lens.
void AddPlacementFlags(command_line::Command measure, JobFlags& job) {
  measure.AddOption("--job", job.job_file,
                    "job file: its models, spacing and lens; options take precedence");
  AddModelFlags(measure, job);
  AddBlockFlag(measure, job);
  AddMarginFlag(measure, job);
  AddSpacingFlag(measure, job);
  AddLensFlags(measure, job);
  measure.OptionOf("--focal").Describe(
      "focal length of the lens, mm: its cracks decide where the glass may break");
  AddSizeLimitsFlag(measure, job.size_limits);
}

}  // namespace

void AddMeasureCommand(command_line::Command app) {
  auto options = std::make_shared<MeasureOptions>();
  command_line::Command measure = app.AddCommand(
      "measure", "measure the quality of a cloud: evenness, coverage, stress");
  measure.AddOption("CLOUD", options->cloud, "points, in any format that can be read")
      .Require();
  AddPlacementFlags(measure, options->job);
  AddAnswers(measure, options->accept);
  measure
      .AddOption("--height-ratio", options->height_ratio,
                 "divide heights by this when pairs are compared, 1..10, default the "
                 "job's, or 1")
      .Within(1.0, 10.0);
  measure
      .AddOption("--channel", options->channel,
                 "of a job that engraves several blocks, the one of this channel")
      .Within(1, 4);
  measure.AddFlag("--json", options->json, "the figures for programs");
  measure.AddFlag("--csv", options->csv, "the figures for spreadsheets")
      .Exclude(measure.OptionOf("--json"));
  measure.AddOption("--picture", options->picture,
                    "map of the nearest distances, picture.png");
  measure.SetFooter(
      "Example: intaglio measure cloud.ply --mesh bunny.obj --rotate 90 0 0 --height 40 "
      "--spacing 0.1 --picture map.png\n"
      "Exit code: 0 the minimum spacing is kept, 3 it is not, 2 wrong input.");
  measure.SetAction([options] { return Measure(*options); });
}

}  // namespace intaglio::cli
