#include "services/client/preview/preview.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "engrave/core/channels.h"
#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "engrave/optics/absorption.h"
#include "engrave/proof/cloud_quality.h"
#include "services/client/preview/depth_hint.h"
#include "services/client/preview/preview_page.h"
#include "services/client/preview/preview_picture.h"
#include "services/client/preview/preview_text.h"
#include "services/client/preview/preview_time.h"
#include "services/client/proof/evidence/proof_figures.h"
#include "services/job/convert/model_kind.h"
#include "services/job/fields/channels.h"
#include "services/job/files/json_text.h"
#include "services/job/machine/head_clearance.h"
#include "services/job/methods/method_table.h"
#include "services/job/models/job_cloud.h"
#include "services/job/quality/cloud_warnings.h"
#include "services/job/quality/focus_spread.h"
#include "services/job/quality/oblique_beams.h"
#include "services/job/quality/pulse_focus.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

void Set(const Vec3& from, Vector3& to) {
  to.set_x(from.x());
  to.set_y(from.y());
  to.set_z(from.z());
}

Box3 BoundsOf(const PointList& points_mm) {
  Box3 box;
  for (const Vec3& p : points_mm) box.Extend(p);
  return box;
}

/// The points of the job with their channels, and the warnings about them.
struct MadeCloud {
  PointCloud cloud;
  std::vector<ChannelMask> masks;
  Warnings warnings;
};

Result<MadeCloud> MakePoints(const JobSpec& job, const PreviewOptions& options,
                             const PreviewProgress& progress) {
  const auto of_stage = [&](const char* stage) -> ProgressSink {
    return [&progress, stage](std::uint64_t done, std::uint64_t total) {
      return !progress || progress(stage, done, total);
    };
  };
  auto made = INTAGLIO_TRY(MakeJobCloud(job, options.limits, options.executor,
                                        {of_stage("read"), of_stage("points")}));
  auto masks = INTAGLIO_TRY(ChannelsOfPoints(job, made.cloud.source));
  return MadeCloud{std::move(made.cloud), std::move(masks), std::move(made.warnings)};
}

void AddModels(const JobSpec& job, const PointCloud& cloud, JobPreview& figures) {
  std::vector<Box3> boxes(static_cast<std::size_t>(job.models_size()));
  std::vector<std::uint64_t> counts(boxes.size(), 0);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    boxes.at(cloud.source[i]).Extend(cloud.points_mm[i]);
    ++counts[cloud.source[i]];
  }
  for (int i = 0; i < job.models_size(); ++i) {
    const Model& model = job.models(i);
    ModelPreview& preview = *figures.add_models();
    preview.set_name(IsText(model)          ? model.text().text()
                     : model.has_code()     ? model.code().text()
                     : model.file().empty() ? "points"
                                            : fs::path(model.file()).filename().string());
    if (const auto kind = KindOf(model)) preview.set_kind(NameOf(*kind));
    if (const Method* method = MethodOf(model)) preview.set_method(method->name());
    const auto at = static_cast<std::size_t>(i);
    preview.set_point_count(counts[at]);
    if (counts[at] == 0) continue;
    Set(boxes[at].size_mm(), *preview.mutable_size_mm());
    Set(boxes[at].min_mm, *preview.mutable_low_mm());
  }
}

void AddQuality(const CloudFindings& found, JobPreview& figures) {
  figures.set_measured_spacing_mm(found.measured_spacing_mm);
  if (!found.crack_risk) return;
  BreakagePreview& breakage = *figures.mutable_breakage();
  breakage.set_crack_share_ratio(found.crack_risk->densest.crack_share);
  breakage.set_max_share_ratio(found.crack_risk->max_share);
  breakage.set_risky_count(found.crack_risk->risky_count);
}

void AddLight(const FrozenJob& job, double lowest_mm, JobPreview& figures) {
  const OpticalValuesRecord& values = job.optics();
  if (!values.has_absorption_per_mm()) return;
  const double height_mm = job.job().block().size_mm().z();
  const optics::LightShares shares = optics::SharesOfLight(
      values.reflectance_ratio(), values.absorption_per_mm(), height_mm);
  LightPreview& light = *figures.mutable_light();
  light.set_reflected_ratio(shares.reflected);
  light.set_absorbed_ratio(shares.absorbed);
  light.set_transmitted_ratio(shares.transmitted);
  light.set_deepest_ratio(optics::LightAtDepth(values.reflectance_ratio(),
                                               values.absorption_per_mm(),
                                               std::max(0.0, height_mm - lowest_mm)));
}

void AddOblique(const ObliqueFigures& found, JobPreview& figures) {
  ObliquePreview& oblique = *figures.mutable_oblique();
  for (const UsableRadii& at : found.radii) {
    UsableRadius& radius = *oblique.add_radii();
    radius.set_depth_mm(at.depth_mm);
    radius.set_radius_mm(at.radius_mm);
    radius.set_max_radius_mm(at.max_radius_mm);
    radius.set_double_radius_mm(at.double_radius_mm);
  }
  oblique.set_weak_count(found.weak.count);
  oblique.set_double_count(found.two_foci.count);
  oblique.set_weakest_ratio(found.weakest_ratio);
  oblique.set_max_apart_mm(found.max_apart_mm);
  oblique.set_needed_energy_mj(found.needed_energy_mj);
  if (found.two_foci.count > 0)
    Set(found.two_foci.first_mm, *oblique.mutable_first_double_mm());
  oblique.set_energy_by_place(found.why_one_energy.empty());
  oblique.set_why_one_energy(found.why_one_energy);
  oblique.set_energy_count(static_cast<std::uint32_t>(found.energies_mj.size()));
  oblique.set_min_energy_mj(found.energies_mj.front());
  oblique.set_max_energy_mj(found.energies_mj.back());
  oblique.set_limited_count(found.limited_count);
}

JobPreview FiguresOf(const FrozenJob& job, const MadeCloud& made,
                     const CloudFindings& found,
                     const std::optional<ObliqueFigures>& oblique,
                     const PreviewOptions& options) {
  JobPreview figures;
  const JobSpec& spec = job.job();
  figures.set_name(spec.name());
  figures.set_software_version(job.software_version());
  figures.set_made_utc(options.made_utc);
  Warnings warnings = options.found;
  warnings.insert(warnings.end(), made.warnings.begin(), made.warnings.end());
  const Warnings spread = FocusSpreadOf(job, made.cloud.points_mm);
  warnings.insert(warnings.end(), spread.begin(), spread.end());
  const Warnings pulses = PulseWarningsOf(job);
  warnings.insert(warnings.end(), pulses.begin(), pulses.end());
  if (oblique) {
    AddOblique(*oblique, figures);
    const Warnings beams = ObliqueWarningsOf(*oblique);
    warnings.insert(warnings.end(), beams.begin(), beams.end());
  }
  warnings.insert(warnings.end(), found.warnings.begin(), found.warnings.end());
  figures.set_verdict(VerdictOf(warnings));
  *figures.mutable_warnings() = RecordsOf(AtLeast(WarningWeight::kNote, warnings));
  figures.set_point_count(made.cloud.size());
  figures.set_min_spacing_mm(spec.discretization().min_spacing_mm());
  SetPlace(spec, made.cloud.points_mm, figures);
  AddQuality(found, figures);
  if (job.optics().has_thermal_strength_k()) {
    figures.set_thermal_strength_k(job.optics().thermal_strength_k());
  }
  if (job.optics().has_local_thermal_strength_k()) {
    figures.set_local_thermal_strength_k(job.optics().local_thermal_strength_k());
  }
  *figures.mutable_pulse() = PulseFocusOf(job);
  AddLight(job, figures.low_mm().z(), figures);
  figures.set_glass(job.material().name());
  figures.set_machine(job.machine().name());
  AddModels(spec, made.cloud, figures);
  figures.set_cloud_checksum(PointChecksum(made.cloud.points_mm));
  *figures.mutable_job() = spec;
  return figures;
}

void DrawPictures(const MadeCloud& made, Preview& preview) {
  const std::vector<ChannelMask> channels = DistinctChannels(made.masks);
  preview.figures.set_picture(kPreviewFile);
  for (const ChannelMask channel : channels) {
    if (channels.size() < 2) break;
    const int number = std::countr_zero(channel) + 1;
    ChannelPreview& row = *preview.figures.add_channels();
    row.set_channel(static_cast<std::uint32_t>(number));
    row.set_picture(fmt::format("preview-channel-{}.png", number));
    row.set_point_count(PointsIn(channel, made.cloud, made.masks).size());
  }
  preview.pictures.push_back(
      {preview.figures.picture(), DrawPreview(preview.figures, made.cloud.points_mm)});
  for (const ChannelPreview& row : preview.figures.channels()) {
    const PointCloud part =
        PointsIn(MaskOfChannel(row.channel()), made.cloud, made.masks);
    preview.pictures.push_back(
        {row.picture(), DrawChannel(preview.figures, row, part.points_mm)});
  }
}

}  // namespace

void SetPlace(const JobSpec& job, const PointList& points_mm, JobPreview& figures) {
  const Box3 box = BoundsOf(points_mm);
  Set(box.size_mm(), *figures.mutable_size_mm());
  Set(box.min_mm, *figures.mutable_low_mm());
  *figures.mutable_block_size_mm() = job.block().size_mm();
  figures.set_margin_mm(job.block().margin_mm());
}

Result<Preview> MakePreview(const FrozenJob& job, const PreviewOptions& options,
                            const PreviewProgress& progress) {
  const auto made = INTAGLIO_TRY(MakePoints(job.job(), options, progress));
  if (progress && !progress("check", 0, 0)) {
    return Fail(ErrorCode::kCancelled, "the preview was cancelled");
  }
  INTAGLIO_TRY(CheckHeadClearance(job, made.cloud.points_mm, PointOrder::kNone));
  const auto oblique = ObliqueFiguresOf(job, made.cloud.points_mm, made.cloud.source);
  if (oblique) INTAGLIO_TRY(CheckOblique(job, *oblique));
  const CloudFindings found =
      FindInCloud(job.job(), job.machine(), made.cloud, made.masks, options.executor);
  Preview preview;
  preview.figures = FiguresOf(job, made, found, oblique, options);
  const ProgressSink timing = [&](std::uint64_t done, std::uint64_t total) {
    return !progress || progress("time", done, total);
  };
  const CloudToTime cloud{made.cloud.points_mm, made.masks};
  const auto time = INTAGLIO_TRY(
      EstimateTime(job, cloud, options.max_planned_points, options.executor, timing));
  *preview.figures.mutable_time() = time;
  const auto slow = INTAGLIO_TRY(SlowDepthAxisIn(
      job, time, cloud, options.max_planned_points, options.executor, timing));
  if (slow) *preview.figures.add_warnings() = RecordOf(*slow);
  if (progress && !progress("picture", 0, 0)) {
    return Fail(ErrorCode::kCancelled, "the preview was cancelled");
  }
  DrawPictures(made, preview);
  preview.points_mm = made.cloud.points_mm;
  return preview;
}

const char* VerdictOf(const Warnings& warnings) {
  switch (GreatestWeight(warnings)) {
    case WarningWeight::kConsent:
      return kNeedsConsent;
    case WarningWeight::kWarning:
      return kReadyWithWarnings;
    case WarningWeight::kNote:
      break;
  }
  return kReady;
}

Status WriteFigures(const fs::path& folder, const JobPreview& figures) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) {
    return Fail(ErrorCode::kIo,
                fmt::format("{}: cannot make the folder: {}; choose another with --out",
                            folder.string(), error.message()),
                folder.string());
  }
  const auto json = INTAGLIO_TRY(JsonTextOf(figures));
  return io::WriteFileAtomically(folder / kPreviewFigures, json);
}

Status WritePreview(const fs::path& folder, const Preview& preview) {
  INTAGLIO_TRY(WriteFigures(folder, preview.figures));
  for (const PreviewPicture& picture : preview.pictures) {
    INTAGLIO_TRY(io::WriteFileAtomically(folder / picture.file,
                                         std::as_bytes(std::span(picture.png))));
  }
  return io::WriteFileAtomically(folder / kPreviewPage, PageOf(preview));
}

}  // namespace intaglio::client
