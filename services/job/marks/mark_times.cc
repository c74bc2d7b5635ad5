// The web moves along +x: a place x of a mark of web_mm enters the field later the larger
// web_mm - x is, which is its coordinate along the web.

#include "services/job/marks/mark_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "engrave/core/try.h"
#include "engrave/galvo/web_order.h"
#include "engrave/mark/jump_order.h"
#include "services/job/head/head_correction.h"
#include "services/job/machine/head_ticks.h"

namespace intaglio {
namespace {

constexpr double kArcToleranceMm = 0.001;
constexpr double kUnitsPerField = 16;
constexpr std::size_t kMaxUnits = 100'000;  // a look-ahead of some seconds

/// Places of the material, as they move with the web.
std::vector<Vec2> PlacesOnWeb(const mark::Mark& mark) {
  std::vector<Vec2> places_mm = mark::PlacesOf(mark, kArcToleranceMm);
  for (Vec2& p : places_mm) p.x() -= mark.web_mm;
  return places_mm;
}

Box3 ExtentOf(const mark::Mark& mark) {
  Box3 box;
  for (const Vec2& p : PlacesOnWeb(mark)) box.Extend(Vec3(p.x(), p.y(), 0));
  return box;
}

/// The place of the material, as it moves with the web.
Vec2 OnWeb(const mark::Mark& mark, const mark::Place& place) {
  return place.at_mm - Vec2(mark.web_mm, 0);
}
Vec2 BeginOnWeb(const mark::Mark& mark) { return OnWeb(mark, mark.places.front()); }
Vec2 EndOnWeb(const mark::Mark& mark) {
  return OnWeb(mark, mark.closed ? mark.places.front() : mark.places.back());
}

/// Commands lead the mirrors by so much at each end of a mark, and have to be in the
/// field.
double LeadMm(const mark::Pen& pen, const HeadFigures& head) {
  return head.ticks.lead_servo ? head.ticks.lag_s * pen.speed_mm_s : 0;
}

/// Displacements of the web at which the mark can be made.
galvo::Span MadeAt(const mark::Mark& mark, const mark::Pen& pen,
                   const HeadFigures& head) {
  return head.window.Displacements(PlacesOnWeb(mark), kWebBorderMm + LeadMm(pen, head));
}

/// In the middle of its displacements, and as long as they leave of the field.
galvo::TimedMark TimedBy(const galvo::Span& made_at, const HeadFigures& head,
                         double time_s) {
  // A mark without an extent is made in the whole field, but for the last digit.
  const double extent_mm = std::max(0.0, head.web_field_mm() - made_at.width_mm());
  return {(made_at.from_mm + made_at.to_mm) / 2, extent_mm, time_s};
}

/// Jumps with a lead of the servo are slower on average than in their middle.
double JumpSpeedOf(const HeadFigures& head) {
  return head.ticks.jump_mm_s / (head.ticks.lead_servo ? 15.0 / 8 : 1);
}

struct Timed {
  double time_s = 0;
  Vec2 end_mm = Vec2::Zero();  ///< where the beam rests, material
};

/// The jump to a mark and all of its passes. A beam that would have to jump farther than
/// the field waits within it for the web.
Timed TimeFrom(const Vec2& from_mm, const mark::Mark& mark, const mark::Pen& pen,
               const HeadFigures& head) {
  const Vec2 begin_mm = BeginOnWeb(mark), way_mm = from_mm - begin_mm;
  const double within = std::min(1.0, head.field_mm() / std::max(way_mm.norm(), 1e-9));
  galvo::MarkTickOptions ticks = head.ticks;
  ticks.mark_mm_s = pen.speed_mm_s;
  const auto counted =
      galvo::CountMarkTicks(StrokesOf(mark, pen), begin_mm + within * way_mm, ticks);
  if (counted)
    return {static_cast<double>(counted->count) / ticks.rate_hz, counted->end_mm};
  // No head makes this mark: its driver names it.
  return {pen.pass_count * mark::LengthOf(mark) / pen.speed_mm_s, EndOnWeb(mark)};
}

/// Marks made one behind the other.
struct Unit {
  std::size_t first = 0, count = 0;
  galvo::Span made_at;  // all of it
  galvo::WebMark mark;
};

class WebOrderer {
 public:
  WebOrderer(mark::MarkSet set, const HeadFigures& head, bool may_reverse)
      : set_(std::move(set)), head_(head), may_reverse_(may_reverse) {}

  Result<mark::MarkSet> Order() {
    if (set_.marks.empty()) return std::move(set_);
    OrderRepeats();
    for (double share = kUnitsPerField; share >= 2; share /= 2) {
      DivideByExtent(head_.web_field_mm() / share);
      if (units_.size() <= kMaxUnits) break;
    }
    std::vector<galvo::WebMark> marks;
    for (const Unit& unit : units_) marks.push_back(unit.mark);
    const galvo::WebHead head{head_.web_field_mm(), JumpSpeedOf(head_)};
    const auto order = units_.size() <= kMaxUnits
                           ? INTAGLIO_TRY(galvo::FastestOrder(marks, head))
                           : INTAGLIO_TRY(galvo::ArrivalOrder(marks, head));
    mark::MarkSet ordered;
    for (const std::size_t k : order.order) {
      const auto from = set_.marks.begin() + static_cast<std::ptrdiff_t>(units_[k].first);
      const auto to = from + static_cast<std::ptrdiff_t>(units_[k].count);
      std::move(from, to, std::back_inserter(ordered.marks));
    }
    ordered.pens = std::move(set_.pens);
    return ordered;
  }

 private:
  void OrderRepeats() {
    std::ranges::stable_sort(set_.marks, {}, &mark::Mark::web_mm);
    auto from = set_.marks.begin();
    while (from != set_.marks.end()) {
      const auto to = std::find_if(from, set_.marks.end(), [&](const mark::Mark& mark) {
        return mark.web_mm != from->web_mm;
      });
      std::vector<mark::Mark> repeat(from, to);
      // What lies at the right arrives first.
      double right_mm = -std::numeric_limits<double>::infinity();
      for (const mark::Mark& mark : repeat)
        for (const mark::Place& place : mark.places)
          right_mm = std::max(right_mm, place.at_mm.x());
      repeat = mark::OrderByJumps(std::move(repeat), {{right_mm, 0}, may_reverse_});
      std::move(repeat.begin(), repeat.end(), from);
      from = to;
    }
  }

  void DivideByExtent(double limit_mm) {
    units_.clear();
    Box3 box;
    double web_mm = 0;
    for (std::size_t i = 0; i < set_.marks.size(); ++i) {
      const mark::Mark& mark = set_.marks[i];
      const galvo::Span made_at = MadeAt(mark, set_.pens[mark.pen], head_);
      Box3 with = box;
      with.Extend(ExtentOf(mark));
      const bool same = !units_.empty() && web_mm == mark.web_mm &&
                        std::max(with.size_mm().x(), with.size_mm().y()) <= limit_mm &&
                        !Both(units_.back().made_at, made_at).empty();
      if (!same) {
        with = ExtentOf(mark);
        units_.push_back({i, 0, made_at, {}});
        web_mm = mark.web_mm;
      }
      box = with;
      AddToUnit(mark, i, made_at, box.center_mm().y(), units_.back());
    }
  }

  static galvo::Span Both(const galvo::Span& a, const galvo::Span& b) {
    return {std::max(a.from_mm, b.from_mm), std::min(a.to_mm, b.to_mm)};
  }

  void AddToUnit(const mark::Mark& mark, std::size_t number, const galvo::Span& made_at,
                 double middle_y_mm, Unit& unit) const {
    const Vec2 from_mm =
        unit.count > 0 ? EndOnWeb(set_.marks[number - 1]) : BeginOnWeb(mark);
    ++unit.count;
    unit.made_at = Both(unit.made_at, made_at);
    unit.mark.mark_s += TimeFrom(from_mm, mark, set_.pens[mark.pen], head_).time_s;
    const auto timed = TimedBy(unit.made_at, head_, unit.mark.mark_s);
    unit.mark.centre_mm = {timed.along_mm, middle_y_mm};
    unit.mark.extent_mm = timed.extent_mm;
  }

  mark::MarkSet set_;
  const HeadFigures head_;
  const bool may_reverse_;
  std::vector<Unit> units_;
};

}  // namespace

double HeadFigures::web_field_mm() const { return field_mm() - 2 * kWebBorderMm; }

MarkTimes TimesOf(const mark::MarkSet& set, const HeadFigures& head) {
  MarkTimes times;
  const mark::Mark* before = nullptr;
  Vec2 at_mm = Vec2::Zero();
  for (const mark::Mark& mark : set.marks) {
    const mark::Pen& pen = set.pens[mark.pen];
    times.mark_mm += pen.pass_count * mark::LengthOf(mark);
    const Vec2 from = before == nullptr ? BeginOnWeb(mark) : EndOnWeb(*before);
    times.jump_mm += std::min((BeginOnWeb(mark) - from).norm(), head.field_mm());
    const Timed timed =
        TimeFrom(before == nullptr ? BeginOnWeb(mark) : at_mm, mark, pen, head);
    times.time_s += timed.time_s;
    at_mm = timed.end_mm;
    before = &mark;
  }
  return times;
}

std::vector<galvo::TimedMark> TimedMarksOf(const mark::MarkSet& set,
                                           const HeadFigures& head) {
  std::vector<galvo::TimedMark> timed;
  Vec2 at_mm = set.marks.empty() ? Vec2(Vec2::Zero()) : BeginOnWeb(set.marks.front());
  for (const mark::Mark& mark : set.marks) {
    const mark::Pen& pen = set.pens[mark.pen];
    const Timed made = TimeFrom(at_mm, mark, pen, head);
    timed.push_back(TimedBy(MadeAt(mark, pen, head), head, made.time_s));
    at_mm = made.end_mm;
  }
  return timed;
}

Status CheckField(const mark::MarkSet& set, bool on_web, const HeadFigures& head) {
  for (std::size_t i = 0; i < set.marks.size(); ++i) {
    const mark::Mark& mark = set.marks[i];
    const mark::Pen& pen = set.pens[mark.pen];
    const auto has = [&](const Vec2& place_mm) { return head.window.Has(place_mm); };
    const bool fits =
        on_web ? MadeAt(mark, pen, head).width_mm() > 0
               : std::ranges::all_of(mark::PlacesOf(mark, kArcToleranceMm), has);
    if (fits) continue;
    const Box3 box = ExtentOf(mark);
    return Fail(
        ErrorCode::kOutsideBlock,
        fmt::format(
            "marks.{}: mark {} lies in x {:.4g}..{:.4g}, y {:.4g}..{:.4g} "
            "mm and does not fit into the field of {:.4g} mm{}; move it, "
            "make it smaller or use a larger field",
            pen.name, i + 1, box.min_mm.x() + mark.web_mm, box.max_mm.x() + mark.web_mm,
            box.min_mm.y(), box.max_mm.y(),
            on_web ? head.web_field_mm() - 2 * LeadMm(pen, head) : head.field_mm(),
            NarrowedText(head.window)),
        fmt::format("{}", head.field_mm()));
  }
  return {};
}

Result<mark::MarkSet> OrderForWeb(mark::MarkSet set, const HeadFigures& head,
                                  bool may_reverse) {
  INTAGLIO_TRY(CheckField(set, true, head));
  return WebOrderer(std::move(set), head, may_reverse).Order();
}

}  // namespace intaglio
