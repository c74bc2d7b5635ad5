#include "services/client/proof_folder.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstdio>

#include "engrave/core/channels.h"
#include "engrave/core/try.h"
#include "engrave/formats/glass_record.h"
#include "engrave/formats/journal_file.h"
#include "engrave/formats/point_file.h"
#include "engrave/io/atomic_file.h"
#include "engrave/proof/glass_comparison.h"
#include "engrave/render/png_file.h"
#include "engrave/render/views.h"
#include "engrave/sort/shadow.h"
#include "services/client/figure_text.h"
#include "services/client/proof_evidence.h"
#include "services/job/json_text.h"
#include "services/job/models/discretize_outcome.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
using formats::PointOutcome;

void Count(const Evidence& evidence, const proof::GlassComparison& glass,
           PointCounts& counts) {
  counts.set_planned(glass.planned_count);
  counts.set_made(glass.made_count);
  counts.set_doubled(glass.doubled_count);
  counts.set_stray(glass.stray_count);
  std::uint64_t skipped = 0, missed = 0, unaccounted = 0;
  for (std::size_t i = 0; i < evidence.plan_mm.size(); ++i) {
    const formats::PointHistory& journaled = evidence.history[i];
    const bool crack = glass.cracks_of_point[i] > 0;
    const bool made = journaled.outcome == PointOutcome::kMade;
    if (crack && made) continue;
    const bool never_tried = journaled.outcome == PointOutcome::kSkipped ||
                             journaled.outcome == PointOutcome::kLeftOut ||
                             journaled.outcome == PointOutcome::kNone;
    if (!crack && never_tried && !journaled.open_intent && !journaled.reopened) {
      ++skipped;
    } else if (!crack && journaled.outcome == PointOutcome::kMissed) {
      ++missed;
    } else {
      ++unaccounted;
    }
  }
  counts.set_skipped(skipped);
  counts.set_missed(missed);
  counts.set_unaccounted(unaccounted);
}

void AddChannels(const proof::GlassComparison& glass,
                 const std::vector<ChannelMask>& masks, JobReport& report) {
  ChannelMask used = 0;
  for (const ChannelMask mask : masks) used |= mask;
  if (std::has_single_bit(used)) return;
  for (std::uint32_t i = 0; i < kMaxChannels; ++i) {
    const proof::ChannelGlass& channel = glass.channels[i];
    if (channel.planned_count + channel.stray_count == 0) continue;
    ChannelCounts& counts = *report.add_channels();
    counts.set_channel(i + 1);
    counts.set_planned(channel.planned_count);
    counts.set_made(channel.made_count);
    counts.set_doubled(channel.doubled_count);
    counts.set_stray(channel.stray_count);
  }
}

/// Errors are from where the points were asked for, moved or not.
double ToleranceUm(const PositionErrors& errors) {
  return errors.tolerance_um() + errors.allowed_move_um();
}

void Judge(JobReport& report) {
  Verdict& verdict = *report.mutable_verdict();
  verdict.clear_reasons();
  const PointCounts& points = report.points();
  const auto need = [&](bool holds, std::string reason) {
    if (!holds) verdict.add_reasons(std::move(reason));
  };
  need(points.planned() > 0, "the plan has no points");
  need(points.doubled() == 0, fmt::format("{} points were made twice", points.doubled()));
  need(points.stray() == 0,
       fmt::format("{} cracks belong to no planned point", points.stray()));
  need(points.skipped() == 0, fmt::format("{} points were skipped", points.skipped()));
  need(points.missed() == 0,
       fmt::format("{} points were fired without a crack", points.missed()));
  need(points.unaccounted() == 0,
       fmt::format("{} points are unaccounted for: journal and glass disagree",
                   points.unaccounted()));
  const PositionErrors& errors = report.position_errors();
  need(errors.max_um() <= ToleranceUm(errors),
       fmt::format("a crack is {:.2f} um off, the tolerance is {:.2f} um",
                   errors.max_um(), ToleranceUm(errors)));
  need(report.shadow_violations() == 0,
       fmt::format("{} points were fired through an earlier crack",
                   report.shadow_violations()));
  need(report.measured_spacing_mm() >= report.min_spacing_mm(),
       fmt::format("two planned points are {:.4f} mm apart, nearer than {:.4f} mm",
                   report.measured_spacing_mm(), report.min_spacing_mm()));
  verdict.set_good(verdict.reasons().empty());
}

JobReport ReportOf(const Evidence& evidence) {
  JobReport report;
  const FrozenJob& frozen = evidence.job;
  report.set_job_uid(frozen.job_uid());
  report.set_name(frozen.job().name());
  report.set_software_version(frozen.software_version());
  *report.mutable_job() = frozen.job();
  *report.mutable_machine() = frozen.machine();
  *report.mutable_material() = frozen.material();
  *report.mutable_optics() = frozen.optics();
  const double spacing_mm = frozen.job().discretization().min_spacing_mm();
  const auto glass = proof::CompareGlass(evidence.plan_mm, evidence.masks,
                                         evidence.cracks, spacing_mm / 2);
  Count(evidence, glass, *report.mutable_points());
  AddChannels(glass, evidence.masks, report);
  PositionErrors& errors = *report.mutable_position_errors();
  errors.set_rms_um(glass.errors.rms_um);
  errors.set_max_um(glass.errors.max_um);
  errors.set_rms_x_um(glass.errors.axis_rms_um.x());
  errors.set_rms_y_um(glass.errors.axis_rms_um.y());
  errors.set_rms_z_um(glass.errors.axis_rms_um.z());
  errors.set_tolerance_um(frozen.machine().position_tolerance_um());
  if (frozen.job().motion().profile() == MOTION_PROFILE_CONTINUOUS) {
    errors.set_allowed_move_um(frozen.job().motion().tolerance_um());
  }
  // The plan's own positions in the order in which the glass got them: the deviation of a
  // crack does not depend on the order.
  PointList made_mm;
  std::vector<ChannelMask> made_masks;
  made_mm.reserve(glass.made_order.size());
  for (const std::uint32_t point : glass.made_order) {
    made_mm.push_back(evidence.plan_mm[point]);
    made_masks.push_back(evidence.masks[point]);
  }
  report.set_shadow_violations(
      sort::CountShadowViolations(made_mm, made_masks, frozen.optics().cone_tangent()));
  report.set_min_spacing_mm(spacing_mm);
  if (evidence.plan_mm.size() > 1) {
    report.set_measured_spacing_mm(proof::MinSpacing(evidence.plan_mm, evidence.masks));
  }
  PointList cracks_mm;
  std::vector<ChannelMask> crack_channels;
  for (const proof::Crack& crack : evidence.cracks) {
    cracks_mm.push_back(crack.position_mm);
    crack_channels.push_back(crack.channel);
  }
  if (cracks_mm.size() > 1) {
    report.set_measured_spacing_in_glass_mm(proof::MinSpacing(cracks_mm, crack_channels));
  }
  if (!evidence.cracks.empty()) {
    const std::uint64_t ticks = glass.last_tick - glass.first_tick + 1;
    report.set_ticks(ticks);
    report.set_utilisation(static_cast<double>(glass.made_order.size()) /
                           static_cast<double>(ticks));
    report.set_machining_time_s(static_cast<double>(ticks) /
                                frozen.job().laser().rate_hz());
  }
  (*report.mutable_checksums())["path"] = PointChecksum(evidence.plan_mm);
  (*report.mutable_checksums())["glass"] = PointChecksum(cracks_mm);
  Judge(report);
  return report;
}

Status WriteViews(const fs::path& file, const Evidence& evidence,
                  const JobReport& report) {
  using render::Tone;
  const auto number = [](std::uint64_t n) { return GroupedDigits(n); };
  const auto good_if = [](bool good) { return good ? Tone::kGood : Tone::kBad; };
  const PointCounts& points = report.points();
  const PositionErrors& errors = report.position_errors();
  render::ViewsCaption caption;
  const Vector3& block = report.job().block().size_mm();
  caption.title_lines = {
      report.name(),
      fmt::format("{}, {:g} x {:g} x {:g} mm, {:g} nm", report.material().name(),
                  block.x(), block.y(), block.z(), report.optics().wavelength_nm()),
      fmt::format("{}, {:g} Hz", report.machine().name(),
                  report.job().laser().rate_hz())};
  caption.figures = {
      {"points planned", number(points.planned())},
      {"made", number(points.made()), good_if(points.made() == points.planned())},
      {"skipped", number(points.skipped()), good_if(points.skipped() == 0)},
      {"missed", number(points.missed()), good_if(points.missed() == 0)},
      {"doubled", number(points.doubled()), good_if(points.doubled() == 0)},
      {"stray", number(points.stray()), good_if(points.stray() == 0)},
      {"shadow violations", number(report.shadow_violations()),
       good_if(report.shadow_violations() == 0)},
      {"minimum spacing", fmt::format("{:.4f} mm", report.measured_spacing_mm()),
       good_if(report.measured_spacing_mm() >= report.min_spacing_mm())},
      {"error, rms", fmt::format("{:.2f} µm", errors.rms_um())},
      {"error, max", fmt::format("{:.2f} µm", errors.max_um()),
       good_if(errors.max_um() <= ToleranceUm(errors))},
      {"ticks", number(report.ticks())},
      {"utilisation", fmt::format("{:.4f}", report.utilisation())},
      {"machining time", ShortDuration(report.machining_time_s())},
      {"estimate", ShortDuration(report.estimated_time_s())}};
  caption.verdict = report.verdict().good() ? "PROVED" : "NOT GOOD";
  caption.verdict_tone = good_if(report.verdict().good());
  PointList cracks_mm;
  for (const proof::Crack& crack : evidence.cracks)
    cracks_mm.push_back(crack.position_mm);
  return render::WritePng(
      file,
      render::RenderViews(cracks_mm, Vec3(block.x(), block.y(), block.z()), caption));
}

/// What one channel made of the block.
Status WriteChannelViews(const fs::path& file, const Evidence& evidence,
                         const JobReport& report, const ChannelCounts& counts) {
  using render::Tone;
  const auto good_if = [](bool good) { return good ? Tone::kGood : Tone::kBad; };
  const auto channel = MaskOfChannel(counts.channel());
  const Vector3& block = report.job().block().size_mm();
  render::ViewsCaption caption;
  caption.title_lines = {report.name(), fmt::format("channel {}", counts.channel())};
  caption.figures = {
      {"points planned", GroupedDigits(counts.planned())},
      {"made", GroupedDigits(counts.made()), good_if(counts.made() == counts.planned())},
      {"doubled", GroupedDigits(counts.doubled()), good_if(counts.doubled() == 0)},
      {"stray", GroupedDigits(counts.stray()), good_if(counts.stray() == 0)}};
  const bool good = counts.made() == counts.planned() && counts.stray() == 0;
  caption.verdict = good ? "COMPLETE" : "NOT GOOD";
  caption.verdict_tone = good_if(good);
  PointList cracks_mm;
  for (const proof::Crack& crack : evidence.cracks) {
    if (crack.channel == channel) cracks_mm.push_back(crack.position_mm);
  }
  return render::WritePng(
      file,
      render::RenderViews(cracks_mm, Vec3(block.x(), block.y(), block.z()), caption));
}

Status WriteGlass(const fs::path& record_file, const fs::path& file) {
  const auto record = INTAGLIO_TRY(formats::ReadGlassRecord(record_file));
  formats::PointTable table;
  std::vector<double> tick;
  std::vector<std::uint8_t> channel;
  for (const auto& crack : record.cracks) {
    if (!crack.in_glass) continue;
    table.points_mm.push_back(crack.position_mm);
    tick.push_back(static_cast<double>(crack.tick));
    channel.push_back(static_cast<std::uint8_t>(crack.channel));
  }
  table.comments = {
      "cracks as recorded by the virtual engraver's glass, glass frame, mm"};
  table.columns = {{"tick", std::move(tick)}, {"channel", std::move(channel)}};
  return formats::WritePly(file, table);
}

Status CopyInto(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
  if (!error) return {};
  return Fail(
      ErrorCode::kIo,
      fmt::format(
          "cannot copy {} to {}: {}; free space on the disk or choose another --out",
          from.string(), to.string(), error.message()),
      to.string());
}

void AddOutcomes(const ProofInputs& inputs, JobReport& report) {
  if (inputs.discretize) *report.mutable_discretize() = inputs.discretize->discretize();
  if (inputs.sort) *report.mutable_sort() = inputs.sort->sort();
  if (inputs.engrave) {
    *report.mutable_engrave() = inputs.engrave->engrave();
    report.set_estimated_time_s(static_cast<double>(report.engrave().estimate_ticks()) /
                                report.job().laser().rate_hz());
    (*report.mutable_checksums())["plan"] = report.engrave().plan_checksum();
  }
  report.set_started_utc(inputs.started_utc);
  report.set_ended_utc(inputs.ended_utc);
  report.set_wall_time_s(inputs.wall_time_s);
  auto& warnings = *report.mutable_warnings();
  warnings.Add(inputs.warnings.begin(), inputs.warnings.end());
  const auto of_points = WarningsOf(report.discretize(), report.job());
  warnings.Add(of_points.begin(), of_points.end());
  warnings.MergeFrom(report.sort().warnings());
}

}  // namespace

std::string UtcNow() {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

std::string PointChecksum(const PointList& points_mm) {
  return fmt::format("{:08x}", formats::PathCrc(points_mm));
}

Result<JobReport> MakeProof(const ProofInputs& inputs) {
  for (const auto& [from, to] :
       {std::pair{inputs.job_folder / "path.ply", "path.ply"},
        std::pair{inputs.job_folder / "job.json", "job.json"},
        std::pair{inputs.job_folder / "journal.bin", "journal.bin"}}) {
    INTAGLIO_TRY(CopyInto(from, inputs.folder / to));
  }
  INTAGLIO_TRY(WriteGlass(inputs.glass_record, inputs.folder / "glass.ply"));
  const auto evidence = INTAGLIO_TRY(ReadEvidence(inputs.folder));
  JobReport report = ReportOf(evidence);
  AddOutcomes(inputs, report);
  INTAGLIO_TRY(WriteViews(inputs.folder / "views.png", evidence, report));
  for (const ChannelCounts& counts : report.channels()) {
    const auto file = fmt::format("views-channel-{}.png", counts.channel());
    INTAGLIO_TRY(WriteChannelViews(inputs.folder / file, evidence, report, counts));
  }
  const auto json = INTAGLIO_TRY(JsonOf(report));
  INTAGLIO_TRY(io::WriteFileAtomically(inputs.folder / "report.json", json));
  return report;
}

Result<JobReport> VerifyFolder(const fs::path& folder) {
  const auto evidence = INTAGLIO_TRY(ReadEvidence(folder));
  return ReportOf(evidence);
}

Result<std::string> JsonOf(const JobReport& report) {
  auto json = JsonTextOf(report);
  if (!json) return Fail(json.error().code, "report.json: " + json.error().message);
  return json;
}

}  // namespace intaglio::client
