#include "services/client/proof/marks/mark_verdict.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/counted.h"
#include "services/client/proof/evidence/proof_figures.h"
#include "services/client/proof/marks/mark_evidence.h"

namespace intaglio::client {
namespace {

constexpr std::size_t kMaxNamed = 3;

/// Names the first of the findings that `has`: ": mark 3 (..) at (..), ..".
template <typename Has>
std::string Named(const MarkReport& marks, std::uint64_t count, const Has& has) {
  std::vector<std::string> names;
  for (const MarkFinding& finding : marks.findings()) {
    if (has(finding) && names.size() < kMaxNamed)
      names.push_back(MarkText(finding.name()));
  }
  if (names.empty()) return "";
  const std::string more =
      count > names.size() ? fmt::format(", and {} more", count - names.size()) : "";
  return fmt::format(": {}{}", fmt::join(names, ", "), more);
}

/// Without those that the journal is uncertain about: they have a sentence of their own.
auto Outcome(std::string_view outcome) {
  return [outcome](const MarkFinding& finding) {
    return finding.outcome() == outcome && !finding.uncertain();
  };
}

std::string UncertainText(const JobReport& report) {
  const MarkCounts& counts = report.marks().counts();
  const std::string names =
      Named(report.marks(), counts.uncertain(),
            [](const MarkFinding& finding) { return finding.uncertain(); });
  if (report.evidence() == kControllerEvidence) {
    return fmt::format(
        "it is unknown whether {} {} made, wholly or in part: check the piece{}",
        Counted(counts.uncertain(), "mark"), WasOrWere(counts.uncertain()), names);
  }
  return fmt::format(
      "{} {} uncertain by the journal; the material has {} whole, {} in part, {} not at "
      "all, {} too often{}",
      Counted(counts.uncertain(), "mark"), IsOrAre(counts.uncertain()),
      counts.uncertain_made(), counts.uncertain_incomplete(), counts.uncertain_missed(),
      counts.uncertain_doubled(), names);
}

struct NamedMeasure {
  const char* name;
  const MarkMeasure& measure;
};

std::string BeyondText(const NamedMeasure& of, double tolerance_um) {
  return fmt::format("{} of {} beyond the tolerance of {:g} um, {:.1f} um at {}", of.name,
                     Counted(of.measure.beyond_count(), "mark"), tolerance_um,
                     of.measure.max_um(), MarkText(of.measure.worst()));
}

void AddEyeFaults(const MarkEyeReport& eye, Verdict& verdict) {
  if (eye.without_print_count() > 0) {
    verdict.add_reasons(fmt::format(
        "{} left out, because the print mark was missing: {}{}",
        Counted(eye.without_print_count(), "repeat"),
        fmt::join(eye.without_print(), ", "),
        eye.without_print_count() > static_cast<std::uint64_t>(eye.without_print_size())
            ? ", and more"
            : ""));
  }
  if (eye.broken_off_count() > 0) {
    verdict.add_reasons(fmt::format(
        "{} begun and not ended before a run ended: the web has taken the rest away",
        Counted(eye.broken_off_count(), "repeat")));
  }
  if (eye.shared_count() > 0) {
    verdict.add_reasons(fmt::format("{} at the print mark of another one",
                                    Counted(eye.shared_count(), "repeat")));
  }
}

}  // namespace

void AddMarkFaults(const JobReport& report, Verdict& verdict) {
  const MarkReport& marks = report.marks();
  const MarkCounts& counts = marks.counts();
  const auto need = [&](bool holds, const auto& reason) {
    if (!holds) verdict.add_reasons(reason());
  };
  const auto none = [&](std::uint64_t count, std::string_view outcome, const char* what) {
    need(count == 0, [&] {
      return fmt::format("{} {} {}{}", Counted(count, "mark"), IsOrAre(count), what,
                         Named(marks, count, Outcome(outcome)));
    });
  };
  need(counts.planned() > 0, [] { return std::string("the job has no marks"); });
  none(counts.doubled() - counts.uncertain_doubled(), "doubled",
       "made twice, in whole or in part");
  none(counts.missed() - counts.uncertain_missed(), "missed",
       report.evidence() == kControllerEvidence
           ? "missed, as the controller reports"
           : "missing in the material, though the journal has them as begun");
  none(counts.incomplete() - counts.uncertain_incomplete(), "incomplete",
       "made in part only");
  none(counts.skipped(), "skipped", "not made: skipped, by the journal");
  if (marks.web().has_eye()) AddEyeFaults(marks.web().eye(), verdict);
  need(counts.uncertain() == 0, [&] { return UncertainText(report); });
  need(counts.unaccounted() == 0, [&] {
    return fmt::format(
        "{} {} in the material, though the journal has them as not begun{}",
        Counted(counts.unaccounted(), "mark"), IsOrAre(counts.unaccounted()),
        Named(marks, counts.unaccounted(),
              [](const MarkFinding& finding) { return finding.unaccounted(); }));
  });
  need(counts.stray_ticks() == 0, [&] {
    return fmt::format("the beam was on for {} of 10 us outside the job's marks",
                       Counted(counts.stray_ticks(), "tick"));
  });
  if (marks.has_cut()) AddCutFaults(marks.cut(), verdict);
  const MarkMeasures& measures = marks.measures();
  const NamedMeasure all[] = {{"place", measures.place()},
                              {"shape", measures.shape()},
                              {"gap", measures.gap()},
                              {"diameter", measures.diameter()}};
  for (const NamedMeasure& of : all) {
    need(of.measure.beyond_count() == 0,
         [&] { return BeyondText(of, measures.tolerance_um()); });
  }
}

}  // namespace intaglio::client
