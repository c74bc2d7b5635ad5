// The web moves along +x: a place x of a mark of web_mm enters the field later the larger
// web_mm - x is, which is its coordinate along the web.

#include "services/job/marks/mark_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
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

/// Displacements of the web at which a mark of these places on it can be made.
galvo::Span MadeAt(std::span<const Vec2> places_mm, const mark::Pen& pen,
                   const HeadFigures& head) {
  return head.window.Displacements(places_mm, kWebBorderMm + LeadMm(pen, head));
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

/// Where a mark lies, and where it can be made.
struct Extent {
  Vec2 min_mm, max_mm;  ///< of the material, as it moves with the web
  galvo::Span made_at;
};

Extent ExtentOnWeb(const mark::Mark& mark, const mark::Pen& pen,
                   const HeadFigures& head) {
  const std::vector<Vec2> places_mm = PlacesOnWeb(mark);
  Extent extent{places_mm.front(), places_mm.front(),
                head.window.Displacements(places_mm, kWebBorderMm + LeadMm(pen, head))};
  for (const Vec2& place_mm : places_mm) {
    extent.min_mm = extent.min_mm.cwiseMin(place_mm);
    extent.max_mm = extent.max_mm.cwiseMax(place_mm);
  }
  return extent;
}

/// Marks made one behind the other.
struct Unit {
  std::size_t first = 0, count = 0;
  Extent extent;  ///< of all of them
};

class WebOrderer {
 public:
  WebOrderer(mark::MarkSet set, const HeadFigures& head, bool may_reverse,
             const ProgressSink& progress)
      : set_(std::move(set)),
        head_(head),
        may_reverse_(may_reverse),
        progress_(progress) {}

  Result<mark::MarkSet> Order() {
    if (set_.marks.empty()) return std::move(set_);
    INTAGLIO_TRY(OrderRepeats());
    const std::vector<Extent> extents = Extents();
    for (double share = kUnitsPerField; share >= 2; share /= 2) {
      DivideByExtent(extents, head_.web_field_mm() / share);
      if (units_.size() <= kMaxUnits) break;
    }
    std::vector<galvo::WebMark> marks;
    for (const Unit& unit : units_) marks.push_back(TimedUnit(unit));
    const galvo::WebHead head{head_.web_field_mm(), JumpSpeedOf(head_)};
    const auto order = units_.size() <= kMaxUnits
                           ? INTAGLIO_TRY(galvo::FastestOrder(marks, head))
                           : INTAGLIO_TRY(galvo::ArrivalOrder(marks, head));
    mark::MarkSet ordered;
    ordered.marks.reserve(set_.marks.size());
    for (const std::size_t k : order.order) {
      const auto from = set_.marks.begin() + static_cast<std::ptrdiff_t>(units_[k].first);
      const auto to = from + static_cast<std::ptrdiff_t>(units_[k].count);
      std::move(from, to, std::back_inserter(ordered.marks));
    }
    ordered.pens = std::move(set_.pens);
    return ordered;
  }

 private:
  Status OrderRepeats() {
    std::ranges::stable_sort(set_.marks, {}, &mark::Mark::web_mm);
    auto from = set_.marks.begin();
    while (from != set_.marks.end()) {
      const auto done = static_cast<std::uint64_t>(from - set_.marks.begin());
      if (progress_ && !progress_(done, set_.marks.size()))
        return Fail(ErrorCode::kCancelled, "the ordering of marks was cancelled");
      const auto to = std::find_if(from, set_.marks.end(), [&](const mark::Mark& mark) {
        return mark.web_mm != from->web_mm;
      });
      std::vector<mark::Mark> repeat(std::make_move_iterator(from),
                                     std::make_move_iterator(to));
      // What lies at the right arrives first.
      double right_mm = -std::numeric_limits<double>::infinity();
      for (const mark::Mark& mark : repeat)
        for (const mark::Place& place : mark.places)
          right_mm = std::max(right_mm, place.at_mm.x());
      repeat = mark::OrderByJumps(std::move(repeat), {{right_mm, 0}, may_reverse_});
      std::move(repeat.begin(), repeat.end(), from);
      from = to;
    }
    return {};
  }

  std::vector<Extent> Extents() const {
    std::vector<Extent> extents;
    extents.reserve(set_.marks.size());
    for (const mark::Mark& mark : set_.marks)
      extents.push_back(ExtentOnWeb(mark, set_.pens[mark.pen], head_));
    return extents;
  }

  void DivideByExtent(const std::vector<Extent>& extents, double limit_mm) {
    units_.clear();
    for (std::size_t i = 0; i < extents.size(); ++i) {
      if (!units_.empty()) {
        Unit& unit = units_.back();
        const Extent with = Both(unit.extent, extents[i]);
        if (set_.marks[unit.first].web_mm == set_.marks[i].web_mm &&
            (with.max_mm - with.min_mm).maxCoeff() <= limit_mm && !with.made_at.empty()) {
          unit.extent = with;
          ++unit.count;
          continue;
        }
      }
      units_.push_back({i, 1, extents[i]});
    }
  }

  static Extent Both(const Extent& a, const Extent& b) {
    return {a.min_mm.cwiseMin(b.min_mm),
            a.max_mm.cwiseMax(b.max_mm),
            {std::max(a.made_at.from_mm, b.made_at.from_mm),
             std::min(a.made_at.to_mm, b.made_at.to_mm)}};
  }

  galvo::WebMark TimedUnit(const Unit& unit) const {
    double time_s = 0;
    for (std::size_t i = unit.first; i < unit.first + unit.count; ++i) {
      const mark::Mark& mark = set_.marks[i];
      const Vec2 from_mm =
          i > unit.first ? EndOnWeb(set_.marks[i - 1]) : BeginOnWeb(mark);
      time_s += TimeFrom(from_mm, mark, set_.pens[mark.pen], head_).time_s;
    }
    const auto timed = TimedBy(unit.extent.made_at, head_, time_s);
    const double middle_y_mm = (unit.extent.min_mm.y() + unit.extent.max_mm.y()) / 2;
    return {{timed.along_mm, middle_y_mm}, timed.extent_mm, time_s};
  }

  mark::MarkSet set_;
  const HeadFigures head_;
  const bool may_reverse_;
  const ProgressSink& progress_;
  std::vector<Unit> units_;
};

/// Calls `each(mark, pen, timed)` in their order.
template <typename Each>
void ForEachTimed(const mark::MarkSet& set, const HeadFigures& head, Each each) {
  Vec2 at_mm = set.marks.empty() ? Vec2(Vec2::Zero()) : BeginOnWeb(set.marks.front());
  for (const mark::Mark& mark : set.marks) {
    const mark::Pen& pen = set.pens[mark.pen];
    const Timed timed = TimeFrom(at_mm, mark, pen, head);
    at_mm = timed.end_mm;
    each(mark, pen, timed);
  }
}

/// Adds marks up, in their order; they stay where they are.
class TimesSum {
 public:
  explicit TimesSum(const HeadFigures& head) : head_(head) {}

  void Add(const mark::Mark& mark, const mark::Pen& pen, const Timed& timed) {
    times_.mark_mm += pen.pass_count * mark::LengthOf(mark);
    const Vec2 from_mm = before_ == nullptr ? BeginOnWeb(mark) : EndOnWeb(*before_);
    times_.jump_mm += std::min((BeginOnWeb(mark) - from_mm).norm(), head_.field_mm());
    times_.time_s += timed.time_s;
    before_ = &mark;
  }
  const MarkTimes& times() const { return times_; }

 private:
  const HeadFigures& head_;
  MarkTimes times_;
  const mark::Mark* before_ = nullptr;
};

}  // namespace

double HeadFigures::web_field_mm() const { return field_mm() - 2 * kWebBorderMm; }

MarkTimes TimesOf(const mark::MarkSet& set, const HeadFigures& head) {
  TimesSum sum(head);
  ForEachTimed(set, head,
               [&](const mark::Mark& mark, const mark::Pen& pen, const Timed& timed) {
                 sum.Add(mark, pen, timed);
               });
  return sum.times();
}

std::vector<galvo::TimedMark> TimedMarksOf(const mark::MarkSet& set,
                                           const HeadFigures& head, MarkTimes* times) {
  TimesSum sum(head);
  std::vector<galvo::TimedMark> marks;
  marks.reserve(set.marks.size());
  ForEachTimed(set, head,
               [&](const mark::Mark& mark, const mark::Pen& pen, const Timed& timed) {
                 marks.push_back(
                     TimedBy(MadeAt(PlacesOnWeb(mark), pen, head), head, timed.time_s));
                 if (times != nullptr) sum.Add(mark, pen, timed);
               });
  if (times != nullptr) *times = sum.times();
  return marks;
}

Status CheckField(const mark::MarkSet& set, bool on_web, const HeadFigures& head) {
  for (std::size_t i = 0; i < set.marks.size(); ++i) {
    const mark::Mark& mark = set.marks[i];
    const mark::Pen& pen = set.pens[mark.pen];
    const auto has = [&](const Vec2& place_mm) { return head.window.Has(place_mm); };
    const bool fits =
        on_web ? MadeAt(PlacesOnWeb(mark), pen, head).width_mm() > 0
               : std::ranges::all_of(mark::PlacesOf(mark, kArcToleranceMm), has);
    if (fits) continue;
    const Extent extent = ExtentOnWeb(mark, pen, head);
    return Fail(
        ErrorCode::kOutsideBlock,
        fmt::format(
            "marks.{}: mark {} lies in x {:.4g}..{:.4g}, y {:.4g}..{:.4g} "
            "mm and does not fit into the field of {:.4g} mm{}; move it, "
            "make it smaller or use a larger field",
            pen.name, i + 1, extent.min_mm.x() + mark.web_mm,
            extent.max_mm.x() + mark.web_mm, extent.min_mm.y(), extent.max_mm.y(),
            on_web ? head.web_field_mm() - 2 * LeadMm(pen, head) : head.field_mm(),
            NarrowedText(head.window)),
        fmt::format("{}", head.field_mm()));
  }
  return {};
}

Result<mark::MarkSet> OrderForWeb(mark::MarkSet set, const HeadFigures& head,
                                  bool may_reverse, const ProgressSink& progress) {
  INTAGLIO_TRY(CheckField(set, true, head));
  return WebOrderer(std::move(set), head, may_reverse, progress).Order();
}

}  // namespace intaglio
