#pragma once

// Which of many boxes meet: a grid of squares, each with the boxes that reach into it.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"

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

}  // namespace intaglio::contour
