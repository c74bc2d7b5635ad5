#pragma once

// Which of many boxes meet: a grid of squares, each with the boxes that reach into it.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

struct FlatBox {
  Vec2 min_mm;
  Vec2 max_mm;
};

struct Pair {
  std::uint32_t first;  ///< lower than second
  std::uint32_t second;
};

/// All pairs of boxes that meet or are nearer than margin_mm to each other along both
/// axes, each once. The order depends on the boxes alone.
std::vector<Pair> NearPairs(std::span<const FlatBox> boxes, double margin_mm);

/// The same, of edges that a person has drawn: long ones that run askew side by side have
/// as many pairs as the square of their number. Errors: kTooLarge, more than max_pairs,
/// as soon as that is known.
Result<std::vector<Pair>> NearPairsUpTo(std::span<const FlatBox> boxes, double margin_mm,
                                        std::uint64_t max_pairs);

}  // namespace intaglio::contour
