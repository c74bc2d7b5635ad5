#include "services/synchronizer/pulses/open_points.h"

namespace intaglio::synchronizer {

void OpenPoints::Rewind() {
  cursor_ = 0;
  mask_ = 0;
  if (masks_.empty()) return;
  if (const auto first = FindOpen()) mask_ = masks_[*first];
}

std::optional<std::uint32_t> OpenPoints::Next() {
  const auto point = FindOpen();
  // What comes later in the order, in these channels again, may lie above this one.
  if (!point || (!masks_.empty() && masks_[*point] != mask_)) return std::nullopt;
  cursor_ = *point + 1;
  return point;
}

std::optional<std::uint32_t> OpenPoints::FindOpen() {
  for (;;) {
    const auto point = ledger_.NextOpen(cursor_);
    if (!point || !Shadowed(*point)) return point;
    cursor_ = *point + 1;
  }
}

// Only points later in the order can shadow this one, and only when they were made: after
// a burst of late pulses these are few.
bool OpenPoints::Shadowed(std::uint32_t point) const {
  const Vec3& apex = points_mm_[point];
  const Vec2 lean_ratio = cone_.LeanAt(apex);
  for (std::uint32_t later = point + 1; later < ledger_.ended_below(); ++later) {
    const PointState state = ledger_.state(later);
    const bool crack = state == PointState::kMade || state == PointState::kMissed ||
                       state == PointState::kUncertain;
    if (!crack) continue;
    if (!masks_.empty() && !ShareChannel(masks_[later], masks_[point])) continue;
    if (cone_.Shades(points_mm_[later] - apex, lean_ratio)) return true;
  }
  return false;
}

}  // namespace intaglio::synchronizer
