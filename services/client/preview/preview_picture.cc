#include "services/client/preview/preview_picture.h"

#include <fmt/format.h>

#include "engrave/render/png_file.h"
#include "engrave/render/views.h"
#include "services/client/figure_text.h"
#include "services/client/preview/preview_text.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::client {
namespace {

using render::Tone;

std::vector<std::uint8_t> Draw(const JobPreview& figures, const PointList& points_mm,
                               const render::ViewsCaption& caption) {
  const Vector3& block = figures.block_size_mm();
  return render::EncodePng(
      render::RenderViews(points_mm, Vec3(block.x(), block.y(), block.z()), caption));
}

Tone ToneOf(const JobPreview& figures) {
  return figures.verdict() == kDraft               ? Tone::kPlain
         : figures.verdict() == kReady             ? Tone::kGood
         : figures.verdict() == kReadyWithWarnings ? Tone::kWarning
                                                   : Tone::kBad;
}

std::vector<render::Note> NotesOf(const JobPreview& figures) {
  std::vector<render::Note> notes;
  for (const WarningRecord& record : figures.warnings()) {
    const Warning warning = WarningOf(record);
    notes.push_back({warning.text, warning.weight == WarningWeight::kConsent ? Tone::kBad
                                   : warning.weight == WarningWeight::kWarning
                                       ? Tone::kWarning
                                       : Tone::kPlain});
  }
  return notes;
}

std::string MeasuredSpacing(const JobPreview& figures) {
  return figures.measured_spacing_mm() > 0
             ? fmt::format("{:.4f} mm", figures.measured_spacing_mm())
             : "none: one point";
}

std::vector<render::Figure> FiguresBesideOf(const JobPreview& figures) {
  if (figures.verdict() == kDraft) {
    return {{"points", "about " + GroupedDigits(figures.point_count())},
            {"in this draft", GroupedDigits(figures.draft_count())},
            {"piece", SizeText(figures.size_mm())}};
  }
  std::vector<render::Figure> beside = {
      {"points", GroupedDigits(figures.point_count())},
      {"piece", SizeText(figures.size_mm())},
      {"minimum spacing", MeasuredSpacing(figures)},
      {"machining time", ShortDuration(figures.time().machining_time_s())},
      {"lamp warm-up", ShortDuration(figures.time().warm_up_s())}};
  if (figures.has_breakage()) {
    const BreakagePreview& breakage = figures.breakage();
    beside.push_back(
        {"cracks at the densest place",
         fmt::format("{:.0f} % of {:.0f} %", 100 * breakage.crack_share_ratio(),
                     100 * breakage.max_share_ratio()),
         breakage.risky_count() == 0 ? Tone::kGood : Tone::kBad});
  }
  return beside;
}

}  // namespace

std::vector<std::uint8_t> DrawPreview(const JobPreview& figures,
                                      const PointList& points_mm) {
  const Vector3& block = figures.block_size_mm();
  render::ViewsCaption caption;
  caption.title_lines = {figures.name(),
                         fmt::format("{}, {:g} x {:g} x {:g} mm", figures.glass(),
                                     block.x(), block.y(), block.z()),
                         "preview: planned, not engraved"};
  caption.figures = FiguresBesideOf(figures);
  caption.verdict = figures.verdict() == kDraft               ? "DRAFT"
                    : figures.verdict() == kReady             ? "READY"
                    : figures.verdict() == kReadyWithWarnings ? "READY, WITH WARNINGS"
                                                              : "NOT READY";
  caption.verdict_tone = ToneOf(figures);
  caption.notes = NotesOf(figures);
  return Draw(figures, points_mm, caption);
}

std::vector<std::uint8_t> DrawChannel(const JobPreview& figures,
                                      const ChannelPreview& channel,
                                      const PointList& points_mm) {
  render::ViewsCaption caption;
  caption.title_lines = {figures.name(), fmt::format("channel {}", channel.channel()),
                         "preview: planned, not engraved"};
  caption.figures = {{"points", GroupedDigits(channel.point_count())}};
  return Draw(figures, points_mm, caption);
}

}  // namespace intaglio::client
