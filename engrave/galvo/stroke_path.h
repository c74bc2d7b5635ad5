#pragma once

#include <vector>

#include "engrave/galvo/mark_ticks.h"

namespace intaglio::galvo {

/// A polyline by its arc length, mm; before its begin and behind its end it goes on: a
/// closed one around, an open one straight.
class StrokePath {
 public:
  /// Two places or more that are not all the same.
  StrokePath(std::vector<Vec2> points_mm, bool closed);

  double length_mm() const { return ends_mm_.back(); }
  Vec2 At(double along_mm) const;
  /// Direction of the motion there, length 1.
  Vec2 DirectionAt(double along_mm) const;

 private:
  std::size_t SegmentAt(double along_mm) const;
  double Within(double along_mm) const;

  std::vector<Vec2> points_mm_;  // of a closed one with the first again
  std::vector<double> ends_mm_;  // arc length at each point
  bool closed_;
  mutable std::size_t last_ = 0;  // segment of the last call: calls go forward
};

/// A stroke from corner to corner: parts that turn by less than the corner's angle at
/// each place. Without a corner a closed stroke is one closed part.
struct StrokePart {
  std::vector<Vec2> points_mm;
  bool closed = false;
  double turn_rad = 0;  ///< of the corner behind it; 0: the stroke ends
};

std::vector<StrokePart> PartsOf(const MarkStroke& stroke);

}  // namespace intaglio::galvo
