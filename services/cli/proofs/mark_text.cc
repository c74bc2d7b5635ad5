#include "services/cli/proofs/mark_text.h"

#include <fmt/format.h>

#include "services/client/figure_text.h"
#include "services/client/proof/evidence/proof_figures.h"
#include "services/client/proof/marks/mark_evidence.h"

namespace intaglio::cli {
namespace {

using client::GroupedDigits;

std::string MarkCountsText(const JobReport& report) {
  const MarkCounts& counts = report.marks().counts();
  std::string text =
      fmt::format("marks       {} planned, {} made, {} skipped, {} missed, ",
                  GroupedDigits(counts.planned()), GroupedDigits(counts.made()),
                  GroupedDigits(counts.skipped()), GroupedDigits(counts.missed()));
  if (report.evidence() == client::kControllerEvidence) {
    return text + fmt::format(
                      "{} uncertain\nevidence    the memory of the machine's "
                      "controller; the piece was not measured\n",
                      GroupedDigits(counts.uncertain()));
  }
  text += fmt::format("{} incomplete, {} doubled\n", GroupedDigits(counts.incomplete()),
                      GroupedDigits(counts.doubled()));
  if (counts.dots() > 0) {
    text += fmt::format("dots        {} in rows, {} missed, in part or too often\n",
                        GroupedDigits(counts.dots()), GroupedDigits(counts.wrong_dots()));
  }
  text += fmt::format("journal     {} uncertain", GroupedDigits(counts.uncertain()));
  if (counts.uncertain() > 0) {
    text += fmt::format(" (in the material: {} whole, {} in part, {} not, {} too often)",
                        counts.uncertain_made(), counts.uncertain_incomplete(),
                        counts.uncertain_missed(), counts.uncertain_doubled());
  }
  return text + fmt::format(", {} unaccounted, {}\n", GroupedDigits(counts.unaccounted()),
                            client::GroupedCount(counts.stray_ticks(), "stray tick"));
}

std::string MeasureText(const char* name, const MarkMeasure& measure) {
  if (measure.count() == 0) return "";
  return fmt::format("{:<12}{:.1f} um rms, {:.1f} um max: {}\n", name, measure.rms_um(),
                     measure.max_um(), client::MarkText(measure.worst()));
}

std::string MeasuresText(const MarkMeasures& measures) {
  return MeasureText("place", measures.place()) + MeasureText("shape", measures.shape()) +
         MeasureText("gap", measures.gap()) +
         MeasureText("diameter", measures.diameter()) +
         fmt::format("tolerance   {:g} um\n", measures.tolerance_um());
}

std::string EnergyText(const MarkEnergy& energy) {
  return fmt::format(
      "energy      {}: {:.4g} mJ/mm median, {:.2g} % spread, {:.2g} % furthest off: {}\n",
      energy.item(), energy.median_mj_mm(), 100 * energy.spread_ratio(),
      100 * energy.furthest_ratio(), client::MarkText(energy.furthest()));
}

std::string WebText(const MarkWebReport& web) {
  std::string text =
      fmt::format("web         {:.1f} mm, at most {:.1f} mm/s in this order",
                  web.length_mm(), web.largest_mm_s());
  if (web.asked_mm_s() > 0) text += fmt::format(", {:g} mm/s asked", web.asked_mm_s());
  if (web.marked_mm_s() > 0)
    text += fmt::format(", marked at {:.1f} mm/s", web.marked_mm_s());
  text += "\n";
  if (!web.has_eye()) return text;
  const MarkEyeReport& eye = web.eye();
  return text + fmt::format(
                    "print       each repeat at its print mark {:+g} mm, pitch {:g} mm; "
                    "{} without one, {} broken off\n",
                    eye.offset_mm(), eye.pitch_mm(), eye.without_print_count(),
                    eye.broken_off_count());
}

}  // namespace

std::string MarkLines(const JobReport& report) {
  const MarkReport& marks = report.marks();
  std::string text = MarkCountsText(report);
  if (report.evidence() != client::kControllerEvidence)
    text += MeasuresText(marks.measures());
  for (const MarkEnergy& energy : marks.energies()) text += EnergyText(energy);
  if (marks.has_cut()) text += client::CutLines(marks.cut());
  if (marks.has_web()) text += WebText(marks.web());
  text += fmt::format("length      {:.4g} m in all passes\n", marks.length_mm() / 1000);
  if (report.machining_time_s() > 0) {
    text +=
        fmt::format("time        {}", client::ShortDuration(report.machining_time_s()));
    if (report.estimated_time_s() > 0)
      text += ", estimate " + client::ShortDuration(report.estimated_time_s());
    text += "\n";
  }
  return text;
}

}  // namespace intaglio::cli
