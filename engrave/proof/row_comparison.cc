#include "engrave/proof/row_comparison.h"

#include <algorithm>
#include <cmath>

namespace intaglio::proof {
namespace {

struct PlannedDot {
  double from_mm, to_mm;  // along the row, from its begin
  Vec2 begin_mm, end_mm;
  double burnt_mm = 0;
  Vec2 sum = Vec2::Zero();  // of the middles of ticks, by their lengths

  double length_mm() const { return to_mm - from_mm; }
  double DistanceAlong(double at_mm) const {
    return std::max({from_mm - at_mm, at_mm - to_mm, 0.0});
  }
};

std::vector<PlannedDot> PlannedDots(std::span<const std::vector<Vec2>> dots,
                                    const Vec2& along) {
  const Vec2& begin_mm = dots.front().front();
  std::vector<PlannedDot> planned;
  planned.reserve(dots.size());
  for (const std::vector<Vec2>& dot : dots) {
    planned.push_back({(dot.front() - begin_mm).dot(along),
                       (dot.back() - begin_mm).dot(along), dot.front(), dot.back()});
  }
  return planned;
}

PlannedDot& NearestDot(std::vector<PlannedDot>& dots, double at_mm) {
  const auto behind = std::ranges::upper_bound(dots, at_mm, {}, &PlannedDot::from_mm);
  if (behind == dots.begin()) return dots.front();
  const auto before = behind - 1;
  if (behind == dots.end()) return *before;
  return before->DistanceAlong(at_mm) <= behind->DistanceAlong(at_mm) ? *before : *behind;
}

double DistanceToDot(const Vec2& place_mm, const PlannedDot& dot) {
  const Vec2 way = dot.end_mm - dot.begin_mm;
  const double share =
      std::clamp((place_mm - dot.begin_mm).dot(way) / way.squaredNorm(), 0.0, 1.0);
  return (place_mm - dot.begin_mm - share * way).norm();
}

}  // namespace

BurntFate BurntRow::fate() const {
  if (doubled_count > 0) return BurntFate::kDoubled;
  return missed_count + incomplete_count > 0 ? BurntFate::kIncomplete : BurntFate::kMade;
}

BurntRow CompareRow(std::span<const std::vector<Vec2>> dots,
                    std::span<const formats::BurntTick> ticks, std::uint32_t pass_count,
                    const Vec2& offset_mm) {
  const Vec2 along = (dots.back().back() - dots.front().front()).normalized();
  std::vector<PlannedDot> planned = PlannedDots(dots, along);
  const Vec2 anchor_mm = ticks.front().place_mm - ticks.front().way_mm;
  BurntRow row;
  double worst_mm = 0;
  for (const formats::BurntTick& tick : ticks) {
    const Vec2 middle_mm = tick.place_mm - tick.way_mm / 2;
    PlannedDot& dot = NearestDot(planned, (middle_mm - anchor_mm).dot(along));
    dot.burnt_mm += tick.way_mm.norm();
    dot.sum += tick.way_mm.norm() * middle_mm;
    worst_mm = std::max(worst_mm, DistanceToDot(tick.place_mm - offset_mm, dot));
  }
  for (const PlannedDot& dot : planned) {
    const BurntFate fate = dot.burnt_mm > 0
                               ? FateOf(dot.burnt_mm, dot.length_mm(), pass_count)
                               : BurntFate::kMissed;
    row.missed_count += fate == BurntFate::kMissed;
    row.incomplete_count += fate == BurntFate::kIncomplete;
    row.doubled_count += fate == BurntFate::kDoubled;
    if (fate != BurntFate::kMade) continue;
    const Vec2 off = dot.sum / dot.burnt_mm - offset_mm - (dot.begin_mm + dot.end_mm) / 2;
    worst_mm = std::max(worst_mm, off.norm());
  }
  row.shape_um = 1e3 * worst_mm;
  return row;
}

}  // namespace intaglio::proof
