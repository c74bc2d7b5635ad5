// Behind which mark another is made changes the jump to it alone, and the place to which
// that jump leads is the mark's own. So the times of marks within a unit are known when
// they are added, and of a unit's first mark what is kept is where it begins.

#include "services/job/marks/web_plan.h"

#include <algorithm>

#include "engrave/core/try.h"

namespace intaglio {
namespace {

constexpr double kUnitsPerField = 16;
constexpr std::size_t kMaxUnits = 100'000;  // a look-ahead of some seconds

/// Jumps with a lead of the servo are slower on average than in their middle.
double JumpSpeedOf(const HeadFigures& head) {
  return head.ticks.jump_mm_s / (head.ticks.lead_servo ? 15.0 / 8 : 1);
}

MarkExtent Both(const MarkExtent& a, const MarkExtent& b) {
  return {a.min_mm.cwiseMin(b.min_mm),
          a.max_mm.cwiseMax(b.max_mm),
          {std::max(a.made_at.from_mm, b.made_at.from_mm),
           std::min(a.made_at.to_mm, b.made_at.to_mm)}};
}

}  // namespace

WebPlan::WebPlan(const HeadFigures& head, Keeps keeps) : head_(head), keeps_(keeps) {
  double units = kUnitsPerField;
  for (Division& division : divisions_) {
    division.limit_mm = head_.web_field_mm() / units;
    units /= 2;
  }
}

void WebPlan::Add(std::span<const MeasuredMark> repeat) {
  for (std::size_t i = 0; i < repeat.size(); ++i) {
    const MeasuredMark& mark = repeat[i];
    const double time_s = TimeFrom(end_mm_, mark.start, head_);
    for (Division& division : divisions_) AddTo(division, mark, time_s, i == 0);
    if (keeps_ == Keeps::kTimes)
      timed_.push_back(
          TimedBy(mark.extent.made_at, head_, TimeFrom(rest_mm_, mark.start, head_)));
    end_mm_ = mark.end_mm;
    rest_mm_ = mark.start.rest_mm;
    ++mark_count_;
  }
}

void WebPlan::AddTo(Division& division, const MeasuredMark& mark, double time_s,
                    bool first_of_repeat) const {
  if (division.too_many) return;
  if (!first_of_repeat && !division.units.empty()) {
    Unit& unit = division.units.back();
    const MarkExtent with = Both(unit.extent, mark.extent);
    if ((with.max_mm - with.min_mm).maxCoeff() <= division.limit_mm &&
        !with.made_at.empty()) {
      unit.extent = with;
      ++unit.marks.count;
      unit.time_s += time_s;
      unit.mark_mm += mark.length_mm;
      unit.jump_mm += JumpMm(unit.end_mm, mark.start, head_);
      unit.end_mm = mark.end_mm;
      unit.rest_mm = mark.start.rest_mm;
      return;
    }
  }
  // The largest units are taken however many there are.
  if (division.units.size() == kMaxUnits && &division != &divisions_.back()) {
    division.units = {};
    division.too_many = true;
    return;
  }
  division.units.push_back({{mark_count_, 1},
                            mark.extent,
                            mark.start,
                            mark.end_mm,
                            mark.start.rest_mm,
                            TimeFrom(mark.start.begin_mm, mark.start, head_),
                            mark.length_mm,
                            0});
}

galvo::WebMark WebPlan::TimedUnit(const Unit& unit) const {
  const auto timed = TimedBy(unit.extent.made_at, head_, unit.time_s);
  const double middle_y_mm = (unit.extent.min_mm.y() + unit.extent.max_mm.y()) / 2;
  return {{timed.along_mm, middle_y_mm}, timed.extent_mm, unit.time_s};
}

Result<std::vector<MarkRange>> WebPlan::Order(const ProgressSink& progress) {
  std::vector<MarkRange> ranges;
  if (mark_count_ == 0) return ranges;
  while (divisions_[chosen_].too_many) ++chosen_;
  for (std::size_t i = 0; i < divisions_.size(); ++i)
    if (i != chosen_) divisions_[i].units = {};
  const std::deque<Unit>& units = divisions_[chosen_].units;
  std::vector<galvo::WebMark> marks;
  marks.reserve(units.size());
  for (const Unit& unit : units) marks.push_back(TimedUnit(unit));
  const galvo::WebHead head{head_.web_field_mm(), JumpSpeedOf(head_)};
  auto order = units.size() <= kMaxUnits
                   ? INTAGLIO_TRY(galvo::FastestOrder(marks, head, progress))
                   : INTAGLIO_TRY(galvo::ArrivalOrder(marks, head));
  order_ = std::move(order.order);
  ranges.reserve(order_.size());
  for (const std::size_t k : order_) ranges.push_back(units[k].marks);
  return ranges;
}

std::vector<galvo::TimedMark> WebPlan::TakeTimes(MarkTimes& times) {
  times = {};
  std::vector<galvo::TimedMark> ordered;
  ordered.reserve(timed_.size());
  const Unit* before = nullptr;
  for (const std::size_t k : order_) {
    const Unit& unit = divisions_[chosen_].units[k];
    const Vec2& from_mm = before == nullptr ? unit.start.begin_mm : before->rest_mm;
    timed_[unit.marks.first].time_s = TimeFrom(from_mm, unit.start, head_);
    if (before != nullptr) times.jump_mm += JumpMm(before->end_mm, unit.start, head_);
    times.jump_mm += unit.jump_mm;
    times.mark_mm += unit.mark_mm;
    for (std::size_t i = 0; i < unit.marks.count; ++i) {
      ordered.push_back(timed_[unit.marks.first + i]);
      times.time_s += ordered.back().time_s;
    }
    before = &unit;
  }
  timed_ = {};
  return ordered;
}

}  // namespace intaglio
