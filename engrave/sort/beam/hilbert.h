#pragma once

// Points along a Hilbert curve: neighbours on the curve are neighbours in space, so that
// the next points that a search reads are near the last ones in memory.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::sort {

/// Place of a cell of a 2048^3 grid on the curve, 33 bits. Coordinates below 2048.
std::uint64_t HilbertKey(std::uint32_t x, std::uint32_t y, std::uint32_t z);

/// `members` (indices into points_mm) sorted along the curve through the cube around
/// them; points of one cell stay as they were. With flat, z is left out.
std::vector<std::uint32_t> AlongHilbertCurve(const PointList& points_mm,
                                             std::span<const std::uint32_t> members,
                                             bool flat);

}  // namespace intaglio::sort
