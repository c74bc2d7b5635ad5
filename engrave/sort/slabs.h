#pragma once

// Points by slabs of equal thickness.

#include <cstdint>
#include <string_view>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::sort {

/// 0.01..100 mm; the sentence names the field.
Status CheckThickness(std::string_view field, double thickness_mm);

/// For each point the number of its slab across `axis` (0..2); the smallest coordinate is
/// in slab 0. There must be a point.
std::vector<std::uint64_t> SlabNumbers(const PointList& points_mm, int axis,
                                       double thickness_mm);

}  // namespace intaglio::sort
