#pragma once

// Elements that are drawn more than once, as by programs that fill areas or repeat
// layers.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/contour/element.h"

namespace intaglio::contour {

/// Of each element the number of the first one that covers the same by the same numbers;
/// a track covers the same in both directions.
std::vector<std::uint32_t> FirstsOfEqual(std::span<const Element> elements);

}  // namespace intaglio::contour
