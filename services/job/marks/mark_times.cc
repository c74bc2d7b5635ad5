#include "services/job/marks/mark_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <span>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/mark/jump_order.h"
#include "services/job/head/head_correction.h"
#include "services/job/machine/head_ticks.h"
#include "services/job/marks/timed_mark.h"
#include "services/job/marks/web_plan.h"

namespace intaglio {
namespace {

constexpr double kArcToleranceMm = 0.001;

/// Calls `each(mark, time_s)` in their order and adds them up.
template <typename Each>
MarkTimes ForEachTimed(const mark::MarkSet& set, const HeadFigures& head, Each each) {
  MarkTimes times;
  Vec2 end_mm, rest_mm;
  for (std::size_t i = 0; i < set.marks.size(); ++i) {
    const mark::Mark& mark = set.marks[i];
    const MeasuredMark measured = Measure(mark, set.pens[mark.pen], head);
    if (i == 0) end_mm = rest_mm = measured.start.begin_mm;
    const double time_s = TimeFrom(rest_mm, measured.start, head);
    times.mark_mm += measured.length_mm;
    times.jump_mm += JumpMm(end_mm, measured.start, head);
    times.time_s += time_s;
    end_mm = measured.end_mm;
    rest_mm = measured.start.rest_mm;
    each(measured, time_s);
  }
  return times;
}

/// From here to before `to` they belong to one repeat.
std::vector<mark::Mark>::iterator EndOfRepeat(std::vector<mark::Mark>::iterator from,
                                              std::vector<mark::Mark>::iterator to) {
  return std::find_if(
      from, to, [&](const mark::Mark& mark) { return mark.web_mm != from->web_mm; });
}

}  // namespace

double HeadFigures::web_field_mm() const { return field_mm() - 2 * kWebBorderMm; }

MarkTimes TimesOf(const mark::MarkSet& set, const HeadFigures& head) {
  return ForEachTimed(set, head, [](const MeasuredMark&, double) {});
}

std::vector<galvo::TimedMark> TimedMarksOf(const mark::MarkSet& set,
                                           const HeadFigures& head, MarkTimes* times) {
  std::vector<galvo::TimedMark> marks;
  marks.reserve(set.marks.size());
  const MarkTimes all =
      ForEachTimed(set, head, [&](const MeasuredMark& mark, double time_s) {
        marks.push_back(TimedBy(mark.extent.made_at, head, time_s));
      });
  if (times != nullptr) *times = all;
  return marks;
}

Status CheckField(const mark::MarkSet& set, bool on_web, const HeadFigures& head) {
  return CheckField(set.marks, 0, set.pens, on_web, head);
}

Status CheckField(std::span<const mark::Mark> marks, std::size_t first,
                  std::span<const mark::Pen> pens, bool on_web, const HeadFigures& head) {
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const mark::Mark& mark = marks[i];
    const mark::Pen& pen = pens[mark.pen];
    const auto has = [&](const Vec2& place_mm) { return head.window.Has(place_mm); };
    const bool fits =
        on_web ? ExtentOf(mark, pen, head).made_at.width_mm() > 0
               : std::ranges::all_of(mark::PlacesOf(mark, kArcToleranceMm), has);
    if (fits) continue;
    const MarkExtent extent = ExtentOf(mark, pen, head);
    return Fail(
        ErrorCode::kOutsideBlock,
        fmt::format(
            "marks.{}: mark {} lies in x {:.4g}..{:.4g}, y {:.4g}..{:.4g} "
            "mm and does not fit into the field of {:.4g} mm{}; move it, "
            "make it smaller or use a larger field",
            pen.name, first + i + 1, extent.min_mm.x() + mark.web_mm,
            extent.max_mm.x() + mark.web_mm, extent.min_mm.y(), extent.max_mm.y(),
            on_web ? head.web_field_mm() - 2 * LeadMm(pen, head) : head.field_mm(),
            NarrowedText(head.window)),
        fmt::format("{}", head.field_mm()));
  }
  return {};
}

std::vector<mark::Mark> OrderRepeat(std::vector<mark::Mark> marks, bool may_reverse) {
  double right_mm = -std::numeric_limits<double>::infinity();
  for (const mark::Mark& mark : marks)
    for (const mark::Place& place : mark.places)
      right_mm = std::max(right_mm, place.at_mm.x());
  return mark::OrderByJumps(std::move(marks), {{right_mm, 0}, may_reverse});
}

Result<mark::MarkSet> OrderForWeb(mark::MarkSet set, const HeadFigures& head,
                                  bool may_reverse, const ProgressSink& progress) {
  INTAGLIO_TRY(CheckField(set, true, head));
  std::ranges::stable_sort(set.marks, {}, &mark::Mark::web_mm);
  WebPlan plan(head, WebPlan::Keeps::kOrder);
  for (auto from = set.marks.begin(); from != set.marks.end();) {
    if (progress && !progress(plan.mark_count(), set.marks.size()))
      return Fail(ErrorCode::kCancelled, "the ordering of marks was cancelled");
    const auto to = EndOfRepeat(from, set.marks.end());
    const auto repeat = OrderRepeat(
        {std::make_move_iterator(from), std::make_move_iterator(to)}, may_reverse);
    plan.Add(MeasureAll(repeat, set.pens, head));
    from = std::ranges::move(repeat, from).out;
  }
  const ProgressSink going_on = [&](std::uint64_t, std::uint64_t) {
    return !progress || progress(set.marks.size(), set.marks.size());
  };
  const auto ranges = INTAGLIO_TRY(plan.Order(going_on));
  mark::MarkSet ordered{std::move(set.pens), {}};
  ordered.marks.reserve(set.marks.size());
  for (const MarkRange& range : ranges) {
    const auto first = set.marks.begin() + static_cast<std::ptrdiff_t>(range.first);
    std::move(first, first + static_cast<std::ptrdiff_t>(range.count),
              std::back_inserter(ordered.marks));
  }
  return ordered;
}

}  // namespace intaglio
