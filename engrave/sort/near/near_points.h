#pragma once

// For each of some points the few that are nearest.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/sort/near/tick_cost.h"

namespace intaglio::sort {

class NearPoints {
 public:
  /// At most `count` for each; a lone point may have none. Distance: the largest of the
  /// axes. typical > 0: a typical distance of a point to the next one, so that few points
  /// are checked.
  NearPoints(std::span<const Scaled> points, std::size_t count, float typical);

  /// The nearest first; equal distances by index.
  std::span<const std::uint32_t> Of(std::uint32_t point) const {
    return {near_.data() + begin_[point], begin_[point + 1] - begin_[point]};
  }

 private:
  std::vector<std::uint32_t> begin_, near_;
};

}  // namespace intaglio::sort
