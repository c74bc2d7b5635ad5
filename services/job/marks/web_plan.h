#pragma once

// The order of marks on a web, of which no mark has to be in memory: parts of the order
// of each repeat become units of a part of the field, and the units are ordered
// (engrave/galvo/web_order.h). Of a mark 24 bytes are kept where its time is asked for.

#include <array>
#include <cstddef>
#include <deque>
#include <span>
#include <vector>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/galvo/web_order.h"
#include "engrave/galvo/web_speed.h"
#include "engrave/mark/mark.h"
#include "services/job/marks/mark_times.h"
#include "services/job/marks/timed_mark.h"

namespace intaglio {

/// Marks made one behind the other, by their numbers.
struct MarkRange {
  std::size_t first = 0, count = 0;
};

class WebPlan {
 public:
  enum class Keeps { kOrder, kTimes };

  WebPlan(const HeadFigures& head, Keeps keeps);

  /// The marks of the next repeat in their order; their numbers go on from those of the
  /// repeat before.
  void Add(std::span<const MeasuredMark> repeat);
  std::size_t mark_count() const { return mark_count_; }

  /// Of all marks that were added. Errors as of FastestOrder.
  Result<std::vector<MarkRange>> Order(const ProgressSink& progress);
  /// Behind Order, once, of kTimes: as of TimedMarksOf in that order.
  std::vector<galvo::TimedMark> TakeTimes(MarkTimes& times);

 private:
  /// Marks made one behind the other.
  struct Unit {
    MarkRange marks;
    MarkExtent extent;   // of all of them
    MarkStart start;     // of the first
    Vec2 end_mm;         // of the last
    Vec2 rest_mm;        // behind the last
    double time_s = 0;   // from the begin of the first
    double mark_mm = 0;  // of all of them
    double jump_mm = 0;  // between them
  };
  /// The units of one size; none when there are too many.
  struct Division {
    double limit_mm = 0;
    std::deque<Unit> units;
    bool too_many = false;
  };

  void AddTo(Division& division, const MeasuredMark& mark, double time_s,
             bool first_of_repeat) const;
  galvo::WebMark TimedUnit(const Unit& unit) const;

  HeadFigures head_;
  const Keeps keeps_;
  std::array<Division, 4> divisions_;  // from the smallest units on
  std::size_t chosen_ = 0;
  std::vector<std::size_t> order_;      // of the units of the chosen division
  std::deque<galvo::TimedMark> timed_;  // by number, in the order of the numbers
  std::size_t mark_count_ = 0;
  Vec2 end_mm_ = Vec2::Zero(), rest_mm_ = Vec2::Zero();  // of the last mark
};

}  // namespace intaglio
