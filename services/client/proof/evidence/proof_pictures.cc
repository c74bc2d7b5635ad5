#include "services/client/proof/evidence/proof_pictures.h"

#include <fmt/format.h>

#include <cmath>

#include "engrave/core/channels.h"
#include "engrave/core/try.h"
#include "engrave/render/png_file.h"
#include "services/client/figure_text.h"
#include "services/client/proof/evidence/proof_figures.h"
#include "services/client/proof/evidence/verdict_text.h"
#include "services/job/verdict/verdict.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
using render::Figure;
using render::Tone;

Tone GoodIf(bool good) { return good ? Tone::kGood : Tone::kBad; }

Vec3 BlockOf(const JobSpec& job) {
  const Vector3& size = job.block().size_mm();
  return {size.x(), size.y(), size.z()};
}

/// To a hundredth.
std::string SizeText(const Vec3& size_mm) {
  const auto rounded = [&](int axis) {
    return std::round(100.0 * size_mm[axis]) / 100.0;
  };
  return fmt::format("{:g} x {:g} x {:g} mm", rounded(0), rounded(1), rounded(2));
}

std::vector<std::string> TitleOf(const JobReport& report, const Box3& work_mm) {
  std::string job = report.job_number() > 0 ? fmt::format("job {}", report.job_number())
                                            : "job " + report.job_uid();
  if (!report.ended_utc().empty()) job += ", " + MinuteText(report.ended_utc());
  if (!work_mm.empty()) job += ", engraving " + SizeText(work_mm.size_mm());
  job += fmt::format(", block {} of {}", SizeText(BlockOf(report.job())),
                     report.material().name());
  return {report.name(), job,
          fmt::format("{}, {:g} Hz, {:g} nm", report.machine().name(),
                      report.job().laser().rate_hz(), report.optics().wavelength_nm())};
}

std::vector<Figure> FiguresIn(const JobReport& report) {
  const PointCounts& points = report.points();
  const PositionErrors& errors = report.position_errors();
  const bool measured = report.evidence() == kGlassEvidence;
  const auto none = [](const char* label, std::uint64_t count) {
    return Figure{label, GroupedDigits(count), GoodIf(count == 0)};
  };
  std::vector<Figure> figures = {
      {"points planned", GroupedDigits(points.planned())},
      {"made", GroupedDigits(points.made()), GoodIf(points.made() == points.planned())},
      none("skipped", points.skipped()),
      none("missed", points.missed())};
  if (measured) {
    figures.push_back(none("doubled", points.doubled()));
    figures.push_back(none("stray", points.stray()));
  } else {
    figures.push_back(none("uncertain", points.unaccounted()));
  }
  figures.push_back(none("shadowed", report.shadow_violations()));
  figures.push_back(
      {"minimum spacing", SpacingText(report), GoodIf(KeepsSpacing(report))});
  if (measured) {
    figures.push_back({"error, rms", fmt::format("{:.2f} µm", errors.rms_um())});
    figures.push_back({"error, max", fmt::format("{:.2f} µm", errors.max_um()),
                       GoodIf(errors.max_um() <= ToleranceUm(errors))});
  }
  figures.push_back({"ticks", GroupedDigits(report.ticks())});
  figures.push_back({"utilisation", fmt::format("{:.4f}", report.utilisation())});
  figures.push_back({"machining time", ShortDuration(report.machining_time_s())});
  if (report.estimated_time_s() > 0) {
    figures.push_back({"estimate", ShortDuration(report.estimated_time_s())});
  }
  return figures;
}

std::vector<render::LegendEntry> LegendOf(bool measured) {
  std::vector<render::LegendEntry> legend = {
      {"skipped", "not fired; the journal has the reason"},
      {"missed", "fired, and no crack was seen"}};
  if (measured) {
    legend.push_back({"doubled", "points with more than one crack"});
    legend.push_back({"stray", "cracks where no point is planned"});
  } else {
    legend.push_back({"uncertain", "unknown whether they were fired"});
  }
  legend.push_back({"shadowed", "fired through an earlier crack"});
  if (measured) {
    legend.push_back({"error", "distance of a crack from its planned point"});
  }
  legend.push_back({"utilisation", "points made in a tick of the lamp"});
  return legend;
}

/// What one channel made of the block.
Status WriteChannelViews(const fs::path& file, const Evidence& evidence,
                         const JobReport& report, const ChannelCounts& counts) {
  const auto channel = MaskOfChannel(counts.channel());
  render::ViewsCaption caption;
  caption.title_lines = {report.name(), fmt::format("channel {}", counts.channel())};
  caption.figures = {
      {"points planned", GroupedDigits(counts.planned())},
      {"made", GroupedDigits(counts.made()), GoodIf(counts.made() == counts.planned())},
      {"doubled", GroupedDigits(counts.doubled()), GoodIf(counts.doubled() == 0)},
      {"stray", GroupedDigits(counts.stray()), GoodIf(counts.stray() == 0)}};
  const bool good = counts.made() == counts.planned() && counts.stray() == 0;
  caption.verdict = good ? "COMPLETE" : "NOT GOOD";
  caption.verdict_tone = GoodIf(good);
  const proof::Cracks& cracks = evidence.cracks;
  PointList cracks_mm;
  for (std::size_t i = 0; i < cracks.size(); ++i) {
    if (cracks.channels[i] == channel) cracks_mm.push_back(cracks.positions_mm[i]);
  }
  return render::WritePng(file,
                          render::RenderViews(cracks_mm, BlockOf(report.job()), caption));
}

}  // namespace

std::string MinuteText(const std::string& utc) {
  if (utc.size() < 16 || utc[10] != 'T') return utc;
  return utc.substr(0, 10) + " " + utc.substr(11, 5) + " UTC";
}

std::vector<render::Note> NotesOf(const JobReport& report, const std::string& evidence) {
  std::vector<render::Note> notes = {{evidence, Tone::kPlain}};
  if (KindOf(report.verdict()) == VerdictKind::kNotGood) {
    for (const std::string& reason : report.verdict().reasons()) {
      notes.push_back({reason, Tone::kBad});
    }
  }
  const Warnings warnings = AtLeast(WarningWeight::kNote, WarningsOf(report.warnings()));
  for (const Warning& warning : warnings) {
    notes.push_back({warning.text, warning.weight == WarningWeight::kNote
                                       ? Tone::kPlain
                                       : Tone::kWarning});
  }
  return notes;
}

render::ViewsCaption ViewsCaptionOf(const JobReport& report, const Box3& work_mm) {
  const bool measured = report.evidence() == kGlassEvidence;
  render::ViewsCaption caption;
  caption.title_lines = TitleOf(report, work_mm);
  caption.figures = FiguresIn(report);
  // What nobody has measured is not proved.
  caption.verdict = VerdictTitle(report.verdict(), measured ? "PROVED" : "COMPLETE");
  caption.verdict_tone = ToneOf(report.verdict());
  caption.notes = NotesOf(
      report, measured ? "Measured: every crack in the glass was compared with the plan."
                       : "By the laser controller's counters. The glass itself was not "
                         "measured: check the piece.");
  caption.legend = LegendOf(measured);
  return caption;
}

const PointList& PicturePoints(const Evidence& evidence, PointList& made_mm) {
  if (evidence.has_glass) return evidence.cracks.positions_mm;
  for (std::size_t i = 0; i < evidence.plan_mm.size(); ++i) {
    if (evidence.history[i].outcome == formats::PointOutcome::kMade) {
      made_mm.push_back(evidence.plan_mm[i]);
    }
  }
  return made_mm;
}

Status WriteViews(const fs::path& folder, const Evidence& evidence,
                  const JobReport& report) {
  PointList made_mm;
  const PointList& points_mm = PicturePoints(evidence, made_mm);
  Box3 work_mm;
  for (const Vec3& p : points_mm) work_mm.Extend(p);
  INTAGLIO_TRY(render::WritePng(folder / "views.png",
                                render::RenderViews(points_mm, BlockOf(report.job()),
                                                    ViewsCaptionOf(report, work_mm))));
  for (const ChannelCounts& counts : report.channels()) {
    INTAGLIO_TRY(
        WriteChannelViews(folder / fmt::format("views-channel-{}.png", counts.channel()),
                          evidence, report, counts));
  }
  return {};
}

Status WriteCustomerPicture(const fs::path& file, const Evidence& evidence,
                            const render::CustomerPicture& picture) {
  PointList made_mm;
  return render::WriteCustomerPicture(file, PicturePoints(evidence, made_mm),
                                      BlockOf(evidence.job.job()), picture);
}

Status WriteCustomerPicture(const fs::path& file, const fs::path& folder,
                            const render::CustomerPicture& picture) {
  const auto evidence = INTAGLIO_TRY(ReadEvidence(folder));
  return WriteCustomerPicture(file, evidence, picture);
}

}  // namespace intaglio::client
