#pragma once

// Parallel lines in what closed contours enclose. Frame: of the piece, mm.

#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::mark {

/// Which of what contours enclose is inside.
enum class InsideRule {
  kEvenOdd,  ///< an odd number of contours: an island in a shape is left free
  kNonZero,  ///< contours of one direction add, of opposite directions cancel
};

struct HatchOptions {
  double distance_mm = 0.1;   ///< of lines, > 0
  double angle_rad = 0;       ///< of lines against x, counterclockwise
  bool cross = false;         ///< a second time, at right angles to the first
  bool bidirectional = true;  ///< each next line comes back
  InsideRule rule = InsideRule::kEvenOdd;
  double inset_mm = 0;  ///< taken off both ends of each chord, along it, >= 0
};

struct Chord {
  Vec2 from_mm = Vec2::Zero();
  Vec2 to_mm = Vec2::Zero();
};

/// Beyond it is kTooLarge: 320 MB.
inline constexpr std::size_t kMaxChords = 10'000'000;

/// Line by line, on each line from its beginning to its end. Lines are exactly the
/// distance apart and lie in the middle of the contours' extent across them, so that the
/// outermost are half to one distance from its ends; of an extent below a distance one
/// line is in its middle. A contour does not repeat its first place; fewer than three
/// places enclose nothing. kInvalidValue: an option out of range or a place that is not
/// finite; kTooLarge.
Result<std::vector<Chord>> Hatch(std::span<const std::vector<Vec2>> contours,
                                 const HatchOptions& options);

}  // namespace intaglio::mark
