#pragma once

// Moves points a little, so that the path through them bends less. Where a step needs two
// ticks because a few per cent of acceleration are missing, a shift of some micrometres,
// less than the repeatability of a stage, makes it one tick.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/motion/segments/segment.h"
#include "engrave/motion/tick_labels.h"

namespace intaglio::motion {

/// How far points were moved.
struct PointMoves {
  double max_mm = 0;
  double square_mm2 = 0;  ///< Sum of the squares.
  std::uint64_t points = 0;

  void Add(double move_mm) {
    max_mm = std::max(max_mm, move_mm);
    square_mm2 += move_mm * move_mm;
    ++points;
  }
  void Add(const PointMoves& other) {
    max_mm = std::max(max_mm, other.max_mm);
    square_mm2 += other.square_mm2;
    points += other.points;
  }
  double rms_mm() const {
    return points == 0 ? 0 : std::sqrt(square_mm2 / static_cast<double>(points));
  }
};

/// Better places for the points of a path from `start` through `targets_mm`. `timed`: the
/// ticks of its steps so far, of which it tries to save some. No point is moved by more
/// than `tolerance_mm` > 0 or out of `travel_mm`, the last not at all.
void ShiftPoints(const KnotState& start, std::span<const Vec3> targets_mm,
                 std::span<const TimedStep> timed, double rate_hz, double tolerance_mm,
                 const Box3& travel_mm, std::vector<Vec3>& shifted_mm);

}  // namespace intaglio::motion
