#include "services/client/proof/marks/mark_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "engrave/core/try.h"
#include "engrave/proof/way_index.h"
#include "engrave/render/png_file.h"
#include "services/client/figure_text.h"
#include "services/client/proof/evidence/proof_files.h"
#include "services/client/proof/evidence/proof_pictures.h"
#include "services/client/proof/evidence/verdict_text.h"
#include "services/client/proof/marks/mark_figures.h"

namespace intaglio::client {
namespace {

using proof::MarkOutcome;
using render::Figure;
using render::Tone;

constexpr double kPictureChordMm = 0.005;
constexpr double kCutNearMm = 0.05;          // as the comparison of cuts
constexpr std::size_t kCandidates = 10'000;  // for close-ups
constexpr double kShownFields = 3;           // a web of a thousand repeats is a thin line

Tone GoodWhen(bool good) { return good ? Tone::kGood : Tone::kBad; }

render::MarkState StateOf(const proof::AccountedMark& mark) {
  // What the material shows comes first.
  switch (mark.outcome) {
    case MarkOutcome::kMade:
      return mark.uncertain ? render::MarkState::kUncertain : render::MarkState::kMade;
    case MarkOutcome::kSkipped:
      return render::MarkState::kSkipped;
    case MarkOutcome::kMissed:
      return render::MarkState::kMissed;
    case MarkOutcome::kIncomplete:
      return render::MarkState::kIncomplete;
    case MarkOutcome::kDoubled:
      return render::MarkState::kDoubled;
    case MarkOutcome::kUncertain:
      break;
  }
  return render::MarkState::kUncertain;
}

render::ShownMark ShownOf(const MarkEvidence& evidence, std::size_t place) {
  const mark::Mark& mark = evidence.marks.marks[place];
  render::ShownMark shown;
  shown.way_mm = mark::PlacesOf(mark, kPictureChordMm);
  if (mark.closed && shown.way_mm.size() > 1)
    shown.way_mm.push_back(shown.way_mm.front());
  for (Vec2& p : shown.way_mm) p.x() -= mark.web_mm;
  if (mark::IsRow(mark))
    for (const mark::Place& at : mark.places) shown.dark.push_back(at.dark);
  shown.middle_mm = mark::MiddleOf(shown.way_mm);
  shown.state = StateOf(evidence.account.marks[place]);
  if (evidence.has_material &&
      evidence.account.marks[place].outcome == MarkOutcome::kMade)
    shown.offset_mm = evidence.compared.marks[place].offset_mm;
  return shown;
}

std::string MicrometreText(double um) { return fmt::format("{:.1f} µm", um); }

std::vector<std::string> CloseUpLines(const MarkEvidence& evidence, std::size_t place) {
  const MarkName name = NameOf(evidence, place);
  const proof::AccountedMark& mark = evidence.account.marks[place];
  std::vector<std::string> lines = {
      fmt::format("{}{}, at ({:.2f}, {:.2f}) mm", name.item(),
                  name.repeat() > 0 ? fmt::format(", repeat {}", name.repeat()) : "",
                  name.x_mm(), name.y_mm())};
  const proof::BurntMark& burnt = evidence.compared.marks[place];
  std::string outcome = OutcomeName(mark.outcome);
  if (mark.uncertain) outcome += "; uncertain by the journal";
  if (mark.unaccounted) outcome += "; not begun by the journal";
  if (mark.outcome != MarkOutcome::kMade) {
    lines.push_back(
        fmt::format("{}, burnt {:.0f} % of one pass", outcome, 100 * burnt.pass_count));
    return lines;
  }
  if (!mark.is_right()) lines.push_back(outcome);
  std::string errors = "place " + MicrometreText(1e3 * burnt.offset_mm.norm()) +
                       ", shape " + MicrometreText(burnt.shape_um);
  if (burnt.gap_um) errors += ", gap " + MicrometreText(*burnt.gap_um);
  if (burnt.diameter_um)
    errors += fmt::format(", diameter {:+.1f} µm", *burnt.diameter_um);
  lines.push_back(errors);
  return lines;
}

/// What is wrong first; then the largest error of each item, for lines of one item are
/// alike.
std::vector<std::size_t> CloseUpMarks(const MarkEvidence& evidence, double tolerance_um) {
  const auto gravest = GravestMarks(evidence, kCandidates);
  std::vector<std::size_t> chosen;
  std::set<std::uint32_t> items;
  const auto choose = [&](const auto& is_wanted) {
    for (const std::size_t place : gravest) {
      if (chosen.size() == render::kMaxCloseUps) return;
      if (std::ranges::find(chosen, place) != chosen.end() || !is_wanted(place)) continue;
      chosen.push_back(place);
      items.insert(evidence.marks.marks[place].pen);
    }
  };
  choose([&](std::size_t place) {
    return !evidence.account.marks[place].is_right() ||
           LargestErrorUm(evidence.compared.marks[place]) > tolerance_um;
  });
  choose([&](std::size_t place) {
    return !items.contains(evidence.marks.marks[place].pen);
  });
  choose([](std::size_t) { return true; });
  return chosen;
}

/// Steps of the tool along that mark.
void AddCutStrokes(const std::vector<proof::CutStep>& steps,
                   const render::ShownMark& mark,
                   std::vector<render::BurntStroke>& strokes) {
  std::vector<proof::CutStep> chords;
  for (std::size_t i = 1; i < mark.way_mm.size(); ++i) {
    const Vec2 &from = mark.way_mm[i - 1], &to = mark.way_mm[i];
    chords.push_back({Vec3(from.x(), from.y(), 0), Vec3(to.x(), to.y(), 0)});
  }
  const proof::WayIndex way(chords);
  const auto is_near = [&](const Vec3& place) {
    return way.ToNearest(place.head<2>(), 0, kCutNearMm).has_value();
  };
  for (const proof::CutStep& step : steps) {
    if (step.to_mm.z() >= 0 || !is_near(step.from_mm) || !is_near(step.to_mm)) continue;
    strokes.push_back({step.from_mm.head<2>(), step.to_mm.head<2>()});
  }
}

void AddCloseUps(const MarkEvidence& evidence, render::MarkViews& views) {
  if (!evidence.has_material) return;
  for (const std::size_t place : CloseUpMarks(evidence, views.tolerance_um)) {
    render::CloseUp close_up;
    close_up.title = fmt::format("Mark {}", place + 1);
    close_up.lines = CloseUpLines(evidence, place);
    close_up.mark = ShownOf(evidence, place);
    if (evidence.cut)
      AddCutStrokes(evidence.cut->compared.sheet_steps, close_up.mark, close_up.burnt);
    const Vec2 shift_mm(evidence.compared.marks[place].web_shift_mm, 0);
    for (const formats::BurntTick& tick : evidence.burnt) {
      if (tick.mark != place) continue;
      close_up.burnt.push_back(
          {tick.place_mm - tick.way_mm - shift_mm, tick.place_mm - shift_mm});
    }
    views.close_ups.push_back(std::move(close_up));
  }
}

void AddShown(const MarkEvidence& evidence, render::MarkViews& views) {
  const double field_mm = evidence.job.machine().scan_head().field_mm();
  const double end_mm = kShownFields * field_mm;
  Box3 box;
  for (std::size_t i = 0; i < evidence.marks.marks.size(); ++i) {
    if (evidence.on_web() && evidence.marks.marks[i].web_mm > end_mm) continue;
    views.marks.push_back(ShownOf(evidence, i));
    for (const Vec2& p : views.marks.back().way_mm) box.Extend(Vec3(p.x(), p.y(), 0));
  }
  if (box.empty()) return;
  if (!evidence.on_web()) {
    views.heading = "from above, all of the piece";
    // Where the marks take a part of the field that can be seen.
    if (box.size_mm().maxCoeff() > field_mm / 2) views.field_mm = field_mm;
  } else if (views.marks.size() == evidence.marks.marks.size()) {
    views.heading = "from above, all of the web, which runs to the right";
  } else {
    views.heading = fmt::format(
        "from above, the first {:.0f} mm of the web, which runs "
        "to the right",
        box.size_mm().x());
  }
}

std::vector<std::string> MarkTitle(const JobReport& report) {
  std::string job = report.job_number() > 0 ? fmt::format("job {}", report.job_number())
                                            : "job " + report.job_uid();
  if (!report.ended_utc().empty()) job += ", " + MinuteText(report.ended_utc());
  job += fmt::format(", {}, {:.4g} m",
                     GroupedCount(report.marks().counts().planned(), "mark"),
                     report.marks().length_mm() / 1000);
  std::string machine = report.machine().name();
  if (report.machine().has_scan_head())
    machine += fmt::format(", field of {:g} mm", report.machine().scan_head().field_mm());
  return {report.name(), job, machine};
}

void AddMeasureFigures(const MarkMeasures& measures, std::vector<Figure>& figures) {
  const auto add = [&](const char* name, const MarkMeasure& measure) {
    if (measure.count() == 0) return;
    figures.push_back({fmt::format("{}, max", name), MicrometreText(measure.max_um()),
                       GoodWhen(measure.beyond_count() == 0)});
  };
  if (measures.place().count() > 0)
    figures.push_back({"place, rms", MicrometreText(measures.place().rms_um())});
  add("place", measures.place());
  add("shape", measures.shape());
  add("gap", measures.gap());
  add("diameter", measures.diameter());
  figures.push_back({"tolerance", MicrometreText(measures.tolerance_um())});
}

void AddWebFigures(const MarkWebReport& web, std::vector<Figure>& figures) {
  if (web.marked_mm_s() > 0)
    figures.push_back({"web, marked", fmt::format("{:.1f} mm/s", web.marked_mm_s())});
  if (web.largest_mm_s() > 0)
    figures.push_back({"web, possible", fmt::format("{:.1f} mm/s", web.largest_mm_s())});
}

std::vector<Figure> MarkFigures(const JobReport& report) {
  const MarkReport& marks = report.marks();
  const MarkCounts& counts = marks.counts();
  const auto none = [](const char* label, std::uint64_t count) {
    return Figure{label, GroupedDigits(count), GoodWhen(count == 0)};
  };
  std::vector<Figure> figures = {
      {"marks planned", GroupedDigits(counts.planned())},
      {"made", GroupedDigits(counts.made()), GoodWhen(counts.made() == counts.planned())},
      none("skipped", counts.skipped()),
      none("missed", counts.missed())};
  const bool measured = report.evidence() == kMaterialEvidence;
  if (measured) {
    figures.push_back(none("incomplete", counts.incomplete()));
    figures.push_back(none("doubled", counts.doubled()));
  }
  figures.push_back(none("uncertain", counts.uncertain()));
  if (measured) {
    AddMeasureFigures(marks.measures(), figures);
    for (const MarkEnergy& energy : marks.energies())
      figures.push_back({"energy, " + energy.item(),
                         fmt::format("{:.3g} mJ/mm ± {:.2g} %", energy.median_mj_mm(),
                                     100 * energy.spread_ratio())});
  }
  if (marks.has_web()) AddWebFigures(marks.web(), figures);
  if (report.machining_time_s() > 0)
    figures.push_back({"time", ShortDuration(report.machining_time_s())});
  return figures;
}

std::vector<render::LegendEntry> MarkLegend(bool measured) {
  std::vector<render::LegendEntry> legend = {
      {"skipped", "not begun, by the journal"},
      {"missed", measured ? "begun, and not in the material" : "by the controller"},
      {"uncertain", "begun, and not known to have ended"}};
  if (!measured) return legend;
  legend.push_back({"incomplete", "less of it than planned"});
  legend.push_back({"doubled", "more of it than planned"});
  legend.push_back({"place", "of the middle of a mark"});
  legend.push_back({"shape", "from its way, the middles upon each other"});
  legend.push_back({"gap", "that a closed mark has"});
  return legend;
}

render::ViewsCaption MarkCaption(const JobReport& report) {
  const bool measured = report.evidence() == kMaterialEvidence;
  render::ViewsCaption caption;
  caption.title_lines = MarkTitle(report);
  caption.figures = MarkFigures(report);
  caption.verdict = VerdictTitle(report.verdict(), measured ? "PROVED" : "COMPLETE");
  caption.verdict_tone = ToneOf(report.verdict());
  caption.notes = NotesOf(report, measured ? "Measured: everything that the machine did "
                                             "was compared with the job."
                                           : "Not measured: the controller reports what "
                                             "became of each mark; nobody looked at the "
                                             "piece.");
  caption.legend = MarkLegend(measured);
  return caption;
}

}  // namespace

render::MarkViews MarkViewsOf(const MarkEvidence& evidence, const JobReport& report) {
  render::MarkViews views;
  views.caption = MarkCaption(report);
  views.tolerance_um = report.marks().measures().tolerance_um();
  AddShown(evidence, views);
  if (!evidence.has_material) return views;
  for (std::size_t i = 0; i < evidence.account.marks.size(); ++i) {
    const proof::AccountedMark& mark = evidence.account.marks[i];
    views.errors.push_back({mark.outcome == MarkOutcome::kMade
                                ? LargestErrorUm(evidence.compared.marks[i])
                                : 0,
                            StateOf(mark)});
  }
  AddCloseUps(evidence, views);
  return views;
}

Status WriteViews(const std::filesystem::path& folder, const MarkEvidence& evidence,
                  const JobReport& report) {
  if (evidence.cut) INTAGLIO_TRY(WriteSheetPicture(folder / kSheetFile, *evidence.cut));
  return render::WritePng(folder / kViewsFile,
                          render::DrawMarkViews(MarkViewsOf(evidence, report)));
}

}  // namespace intaglio::client
