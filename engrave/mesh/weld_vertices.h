#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::mesh {

/// Gives equal points the same index. Two points are equal when their three
/// coordinates are, bit for bit, with -0.0 taken for 0.0. Indices follow the order
/// of first appearance, so the result depends on nothing but the sequence of calls.
/// Frame and unit are the caller's. Coordinates must be finite.
///
/// An open-addressing table of indices with linear probing, at most half full; a
/// corner costs tens of nanoseconds where a general-purpose weld by tolerance, which
/// sorts space first, costs microseconds and would also join points that differ.
class VertexWelder {
 public:
  VertexWelder();

  /// Index of the point: a new one, or that of the equal point added before.
  std::uint32_t Add(const Vec3& point);

  std::size_t size() const { return points_.size(); }

  /// The distinct points, by index. Leaves the welder empty.
  PointList TakePoints();

 private:
  std::size_t SlotOf(const Vec3& normalized) const;
  void Grow();

  PointList points_;
  std::vector<std::uint32_t> slots_;  // index + 1; 0 is free. The size is a power of two.
};

}  // namespace intaglio::mesh
