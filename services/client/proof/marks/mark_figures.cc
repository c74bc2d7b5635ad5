#include "services/client/proof/marks/mark_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>

#include "engrave/mark/mark_file.h"
#include "services/client/proof/evidence/proof_figures.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/machine/head_ticks.h"
#include "services/job/marks/job_marks.h"
#include "services/job/marks/mark_times.h"
#include "services/job/marks/web_run.h"

namespace intaglio::client {
namespace {

using proof::BurntMark;
using proof::MarkOutcome;

constexpr double kTickS = 1e-5;

void AddCounts(const MarkEvidence& evidence, MarkCounts& counts) {
  const proof::MarkAccount& account = evidence.account;
  counts.set_planned(evidence.marks.marks.size());
  counts.set_made(account.count.made);
  counts.set_skipped(account.count.skipped);
  counts.set_missed(account.count.missed);
  counts.set_incomplete(account.count.incomplete);
  counts.set_doubled(account.count.doubled);
  counts.set_uncertain(account.uncertain_count);
  counts.set_uncertain_made(account.of_uncertain.made);
  counts.set_uncertain_incomplete(account.of_uncertain.incomplete);
  counts.set_uncertain_missed(account.of_uncertain.missed);
  counts.set_uncertain_doubled(account.of_uncertain.doubled);
  counts.set_unaccounted(account.unaccounted_count);
  counts.set_stray_ticks(evidence.compared.stray_tick_count);
  counts.set_dots(evidence.compared.dot_count);
  counts.set_wrong_dots(evidence.compared.wrong_dot_count);
}

/// Measures a mark that was made; none: it has no such measure.
using MeasureOf = std::function<std::optional<double>(const BurntMark&)>;

MarkMeasure Measure(const MarkEvidence& evidence, double tolerance_um,
                    const MeasureOf& measure) {
  MarkMeasure found;
  double sum_of_squares = 0;
  std::size_t worst = 0;
  for (std::size_t i = 0; i < evidence.compared.marks.size(); ++i) {
    if (evidence.account.marks[i].outcome != MarkOutcome::kMade) continue;
    const auto measured = measure(evidence.compared.marks[i]);
    if (!measured) continue;
    const double um = std::abs(*measured);
    sum_of_squares += um * um;
    if (found.count() == 0 || um > found.max_um()) {
      found.set_max_um(um);
      worst = i;
    }
    found.set_count(found.count() + 1);
    if (um > tolerance_um) found.set_beyond_count(found.beyond_count() + 1);
  }
  if (found.count() == 0) return found;
  found.set_rms_um(std::sqrt(sum_of_squares / static_cast<double>(found.count())));
  *found.mutable_worst() = NameOf(evidence, worst);
  return found;
}

std::optional<double> PlaceUm(const BurntMark& mark) {
  return 1e3 * mark.offset_mm.norm();
}

void AddMeasures(const MarkEvidence& evidence, MarkMeasures& measures) {
  const double tolerance_um = measures.tolerance_um();
  *measures.mutable_place() = Measure(evidence, tolerance_um, PlaceUm);
  *measures.mutable_shape() = Measure(evidence, tolerance_um, [](const BurntMark& mark) {
    return std::optional<double>(mark.shape_um);
  });
  *measures.mutable_gap() =
      Measure(evidence, tolerance_um, [](const BurntMark& mark) { return mark.gap_um; });
  *measures.mutable_diameter() = Measure(
      evidence, tolerance_um, [](const BurntMark& mark) { return mark.diameter_um; });
}

void AddEnergies(const MarkEvidence& evidence, MarkReport& report) {
  std::map<std::uint32_t, std::vector<std::size_t>> of_pen;
  for (std::size_t i = 0; i < evidence.compared.marks.size(); ++i) {
    if (evidence.account.marks[i].outcome == MarkOutcome::kMade &&
        evidence.compared.marks[i].energy_mj_mm > 0)
      of_pen[evidence.marks.marks[i].pen].push_back(i);
  }
  const auto of = [&](std::size_t i) { return evidence.compared.marks[i].energy_mj_mm; };
  for (auto& [pen, places] : of_pen) {
    const auto middle = places.begin() + static_cast<std::ptrdiff_t>(places.size() / 2);
    std::nth_element(places.begin(), middle, places.end(),
                     [&](std::size_t a, std::size_t b) { return of(a) < of(b); });
    const double median = of(*middle);
    const auto off = [&](std::size_t i) { return of(i) / median - 1; };
    double sum = 0, sum_of_squares = 0;
    for (const std::size_t i : places) {
      sum += off(i);
      sum_of_squares += off(i) * off(i);
    }
    const auto count = static_cast<double>(places.size());
    const auto furthest =
        std::max_element(places.begin(), places.end(), [&](std::size_t a, std::size_t b) {
          return std::pair(std::abs(off(a)), b) < std::pair(std::abs(off(b)), a);
        });
    MarkEnergy& energy = *report.add_energies();
    energy.set_item(evidence.marks.pens[pen].name);
    energy.set_mark_count(places.size());
    energy.set_median_mj_mm(median);
    energy.set_spread_ratio(
        std::sqrt(std::max(0.0, sum_of_squares / count - (sum / count) * (sum / count))));
    energy.set_furthest_ratio(std::abs(off(*furthest)));
    *energy.mutable_furthest() = NameOf(evidence, *furthest);
  }
}

/// The web that ran between the first and the last of its marks, by the time between.
void AddMarkedSpeed(const MarkEvidence& evidence, MarkWebReport& web) {
  const formats::BurntTick *first = nullptr, *last = nullptr;
  for (const formats::BurntTick& tick : evidence.burnt) {
    if (tick.mark >= evidence.marks.marks.size()) continue;
    if (first == nullptr) first = &tick;
    last = &tick;
  }
  if (first == nullptr || last->tick == first->tick) return;
  // The web moves along +x: what is marked later lies at a smaller x of it.
  const double run_mm = first->place_mm.x() - last->place_mm.x();
  if (run_mm <= 0) return;
  web.set_marked_mm_s(run_mm / (kTickS * static_cast<double>(last->tick - first->tick)));
}

formats::MarkSkip SkipOf(const formats::PointHistory& mark) {
  return mark.outcome == formats::PointOutcome::kLeftOut
             ? static_cast<formats::MarkSkip>(mark.reason)
             : formats::MarkSkip::kNone;
}

const char* ReasonText(formats::MarkSkip why) {
  switch (why) {
    case formats::MarkSkip::kNoPrintMark:
      return "the print mark of its repeat is missing";
    case formats::MarkSkip::kRepeatBegun:
      return "its repeat was begun in an earlier run";
    case formats::MarkSkip::kNone:
      break;
  }
  return "";
}

void AddEye(const MarkEvidence& evidence, MarkEyeReport& eye) {
  const Marks marks = WithDefaults(evidence.job.job().marks());
  eye.set_pitch_mm(marks.repeats().pitch_mm());
  eye.set_offset_mm(marks.web().eye().offset_mm());
  eye.set_shared_count(evidence.compared.shared_print_count);
  std::set<std::uint32_t> without, broken_off;
  for (std::size_t i = 0; i < evidence.history.size(); ++i) {
    const formats::MarkSkip why = SkipOf(evidence.history[i]);
    const std::uint32_t repeat = NameOf(evidence, i).repeat();
    if (why == formats::MarkSkip::kNoPrintMark) without.insert(repeat);
    if (why == formats::MarkSkip::kRepeatBegun) broken_off.insert(repeat);
  }
  eye.set_without_print_count(without.size());
  eye.set_broken_off_count(broken_off.size());
  for (const std::uint32_t repeat : without) {
    if (eye.without_print_size() == static_cast<int>(kMaxFindings)) break;
    eye.add_without_print(repeat);
  }
}

void AddWeb(const MarkEvidence& evidence, MarkWebReport& web) {
  if (evidence.job.job().marks().web().has_eye()) AddEye(evidence, *web.mutable_eye());
  web.set_asked_mm_s(evidence.job.job().marks().web().speed_mm_s());
  if (const auto run =
          WebRunOf(evidence.job.job(), evidence.job.machine(), evidence.marks))
    web.set_largest_mm_s(run->max_mm_s);
  Box3 box;
  for (const mark::Mark& mark : evidence.marks.marks)
    for (const mark::Place& place : mark.places)
      box.Extend(Vec3(place.at_mm.x() - mark.web_mm, 0, 0));
  if (!box.empty()) web.set_length_mm(box.size_mm().x());
  AddMarkedSpeed(evidence, web);
}

MarkFinding FindingOf(const MarkEvidence& evidence, std::size_t place) {
  const proof::AccountedMark& mark = evidence.account.marks[place];
  MarkFinding finding;
  *finding.mutable_name() = NameOf(evidence, place);
  finding.set_outcome(OutcomeName(mark.outcome));
  finding.set_uncertain(mark.uncertain);
  finding.set_unaccounted(mark.unaccounted);
  finding.set_reason(ReasonText(SkipOf(evidence.history[place])));
  if (!evidence.has_material) return finding;
  const BurntMark& burnt = evidence.compared.marks[place];
  finding.set_burnt_ratio(
      burnt.pass_count / evidence.marks.pens[evidence.marks.marks[place].pen].pass_count);
  if (mark.outcome != MarkOutcome::kMade) return finding;
  finding.set_place_um(1e3 * burnt.offset_mm.norm());
  finding.set_shape_um(burnt.shape_um);
  if (burnt.gap_um) finding.set_gap_um(*burnt.gap_um);
  if (burnt.diameter_um) finding.set_diameter_um(*burnt.diameter_um);
  finding.set_energy_mj_mm(burnt.energy_mj_mm);
  return finding;
}

/// From the first to the last lit tick.
void AddTime(const MarkEvidence& evidence, JobReport& report) {
  if (evidence.burnt.empty()) return;
  const std::uint64_t ticks =
      evidence.burnt.back().tick - evidence.burnt.front().tick + 1;
  report.set_ticks(ticks);
  report.set_machining_time_s(kTickS * static_cast<double>(ticks));
}

void AddEstimate(const MarkEvidence& evidence, JobReport& report) {
  double length_mm = 0;
  for (const mark::Mark& mark : evidence.marks.marks)
    length_mm += evidence.marks.pens[mark.pen].pass_count * mark::LitLengthOf(mark);
  report.mutable_marks()->set_length_mm(length_mm);
  if (!evidence.job.machine().has_scan_head()) return;
  report.set_estimated_time_s(
      TimesOf(evidence.marks, HeadFiguresOf(evidence.job.machine())).time_s);
}

}  // namespace

double LargestErrorUm(const BurntMark& mark) {
  return std::max({1e3 * mark.offset_mm.norm(), mark.shape_um, mark.gap_um.value_or(0),
                   std::abs(mark.diameter_um.value_or(0))});
}

const char* OutcomeName(MarkOutcome outcome) {
  switch (outcome) {
    case MarkOutcome::kMade:
      return "made";
    case MarkOutcome::kSkipped:
      return "skipped";
    case MarkOutcome::kMissed:
      return "missed";
    case MarkOutcome::kIncomplete:
      return "incomplete";
    case MarkOutcome::kDoubled:
      return "doubled";
    case MarkOutcome::kUncertain:
      break;
  }
  return "uncertain";
}

std::vector<std::size_t> GravestMarks(const MarkEvidence& evidence, std::size_t count) {
  const auto gravity = [&](std::size_t place) {
    const proof::AccountedMark& mark = evidence.account.marks[place];
    const bool measured = evidence.has_material && mark.outcome == MarkOutcome::kMade;
    return std::pair(!mark.is_right(),
                     measured ? LargestErrorUm(evidence.compared.marks[place]) : 0);
  };
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < evidence.account.marks.size(); ++i) {
    // Nothing is known of the errors of a mark that was not measured.
    if (evidence.has_material || !evidence.account.marks[i].is_right())
      places.push_back(i);
  }
  const std::size_t kept = std::min(count, places.size());
  std::partial_sort(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(kept),
                    places.end(), [&](std::size_t a, std::size_t b) {
                      const auto of_a = gravity(a), of_b = gravity(b);
                      return of_a != of_b ? of_a > of_b : a < b;
                    });
  places.resize(kept);
  return places;
}

JobReport FiguresOf(const MarkEvidence& evidence) {
  JobReport report;
  const FrozenJob& frozen = evidence.job;
  report.set_job_uid(frozen.job_uid());
  report.set_name(frozen.job().name());
  report.set_software_version(frozen.software_version());
  *report.mutable_job() = frozen.job();
  *report.mutable_machine() = frozen.machine();
  report.set_evidence(evidence.has_material ? kMaterialEvidence : kControllerEvidence);
  MarkReport& marks = *report.mutable_marks();
  AddCounts(evidence, *marks.mutable_counts());
  marks.mutable_measures()->set_tolerance_um(MarkToleranceUm(frozen.machine()));
  if (evidence.has_material) {
    AddMeasures(evidence, *marks.mutable_measures());
    AddEnergies(evidence, marks);
    AddTime(evidence, report);
  }
  if (evidence.cut) {
    *marks.mutable_cut() = CutReportOf(*evidence.cut);
    report.set_machining_time_s(evidence.cut->compared.figures.work_s);
  }
  AddEstimate(evidence, report);
  if (evidence.on_web()) AddWeb(evidence, *marks.mutable_web());
  for (const std::size_t place : GravestMarks(evidence, kMaxFindings))
    *marks.add_findings() = FindingOf(evidence, place);
  (*report.mutable_checksums())["marks"] =
      fmt::format("{:08x}", mark::MarksCrc(evidence.marks));
  return report;
}

}  // namespace intaglio::client
