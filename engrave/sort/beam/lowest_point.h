#pragma once

// The order of two points that are otherwise equal: the lower one first, then the one of
// smaller y, then of smaller x, then of smaller index. Every sorter breaks its ties so.

#include <cstdint>

#include "engrave/core/geometry.h"

namespace intaglio::sort {

inline bool ComesFirst(const Vec3& a, std::uint32_t a_index, const Vec3& b,
                       std::uint32_t b_index) {
  if (a.z() != b.z()) return a.z() < b.z();
  if (a.y() != b.y()) return a.y() < b.y();
  if (a.x() != b.x()) return a.x() < b.x();
  return a_index < b_index;
}

/// Index of the point that comes first of all; there must be one.
inline std::uint32_t LowestPoint(const PointList& points_mm) {
  std::uint32_t lowest = 0;
  for (std::uint32_t i = 1; i < points_mm.size(); ++i) {
    if (ComesFirst(points_mm[i], i, points_mm[lowest], lowest)) lowest = i;
  }
  return lowest;
}

}  // namespace intaglio::sort
