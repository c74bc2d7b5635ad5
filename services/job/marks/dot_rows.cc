#include "services/job/marks/dot_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "services/job/machine/head_ticks.h"
#include "services/job/marks/job_marks.h"

namespace intaglio {
namespace {

constexpr double kMaxRowSeconds = 0.5;
constexpr double kRowsOfWebField = 8;
constexpr int kGapSteps = 40;  // halvings of the field: below a nanometre

bool HasDots(const MarkItem& item) {
  return item.has_image() && item.image().make() == MARK_IMAGE_MAKE_DOTS;
}

std::string WhyEach(const MarkItem& item, const MachineSpec& machine) {
  if (item.image().dot_mode() == MARK_DOT_MODE_EACH) return "as dot_mode asks";
  return WhyNoDotRows(machine, item.image().dot_mm(), item.pen().speed_mm_s());
}

/// From the last tick of a dot to the first of the next, when its row ends between them:
/// run-out and rest, the jump, and run-in.
double TicksOfBreak(double gap_mm, const HeadFigures& head) {
  const double run = std::round(head.ticks.run_in_s * head.ticks.rate_hz);
  const double run_mm = run / head.ticks.rate_hz * head.ticks.mark_mm_s;
  const double way_mm = std::abs(gap_mm - 2 * run_mm);
  return 3 * run + 2 + static_cast<double>(galvo::CountJumpTicks(way_mm, head.ticks));
}

/// The largest gap that is passed in less time than it is jumped.
double MaxGapMm(const HeadFigures& head) {
  const auto is_jumped = [&](double gap_mm) {
    return gap_mm / head.ticks.mark_mm_s * head.ticks.rate_hz >
           TicksOfBreak(gap_mm, head);
  };
  double passed_mm = 0, jumped_mm = head.field_mm();
  if (!is_jumped(jumped_mm)) return std::numeric_limits<double>::infinity();
  for (int i = 0; i < kGapSteps; ++i) {
    const double gap_mm = (passed_mm + jumped_mm) / 2;
    (is_jumped(gap_mm) ? jumped_mm : passed_mm) = gap_mm;
  }
  return passed_mm;
}

}  // namespace

std::optional<DotRows> DotRowsOf(const MarkItem& item, bool on_web,
                                 const MachineSpec& machine) {
  if (!HasDots(item) || !WhyEach(item, machine).empty()) return std::nullopt;
  HeadFigures head = HeadFiguresOf(machine);
  head.ticks.mark_mm_s = item.pen().speed_mm_s();
  DotRows rows{MaxGapMm(head), kMaxRowSeconds * head.ticks.mark_mm_s};
  if (on_web) rows.max_mm = std::min(rows.max_mm, head.web_field_mm() / kRowsOfWebField);
  return rows;
}

std::string DotModeText(const MarkItem& item, const MachineSpec& machine) {
  if (!HasDots(item)) return {};
  const std::string why = WhyEach(item, machine);
  return why.empty() ? "in rows, the laser is switched while the mirrors sweep"
                     : "each by itself: " + why;
}

void NoteDotModes(const JobSpec& job, const MachineSpec& machine, Warnings& warnings) {
  for (int i = 0; i < job.marks().items_size(); ++i) {
    const MarkItem& item = job.marks().items(i);
    const bool is_asked = item.image().dot_mode() != MARK_DOT_MODE_DEFAULT;
    if (!HasDots(item) || is_asked || WhyEach(item, machine).empty()) continue;
    warnings.push_back(MakeWarning(
        WarningCode::kChosen, fmt::format("marks.items[{}].image.dot_mode: dots {}", i,
                                          DotModeText(item, machine))));
  }
}

}  // namespace intaglio
