#pragma once

// How far apart elements are that do not touch.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/contour/element.h"
#include "engrave/contour/union.h"

namespace intaglio::contour {

struct EdgeGap {
  double distance_mm = 0;
  Vec2 on_first_mm;  ///< the nearest point of the first edge
  Vec2 on_second_mm;
};

/// Between the nearest points of two edges that do not cross.
EdgeGap GapBetween(const Edge& first, const Edge& second);

struct Gap {
  std::uint32_t first = 0;  ///< element, lower than second
  std::uint32_t second = 0;
  double width_mm = 0;
  Vec2 place_mm;  ///< in its middle
};

/// The narrowest gap between each two groups that is narrower than width_mm, the
/// narrowest first. `groups` as of the union of these elements; they are rounded.
Result<std::vector<Gap>> NarrowGaps(std::span<const Element> elements,
                                    std::span<const std::uint32_t> groups,
                                    double width_mm);

}  // namespace intaglio::contour
