#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::mesh {

/// VertexWelder (weld_vertices.h) for the 32-bit floats of a mesh file, for millions of
/// corners: it gives the same indices for the same corners in the same order.
///
/// The cost of a corner is memory latency. So a slot of the table holds the coordinates
/// next to the index (one access instead of VertexWelder's two), and corners are added in
/// batches, whose slots are prefetched long before they are needed.
class CornerWelder {
 public:
  using Corner = std::array<float, 3>;

  /// `expected_count` distinct corners need no growth; more are fine.
  explicit CornerWelder(std::size_t expected_count);

  /// Writes the index of each corner. Corners must be finite; `indices` is as long.
  void Add(std::span<const Corner> corners, std::span<std::uint32_t> indices);

  /// The distinct corners, by index. Leaves the welder empty.
  PointList TakePoints();

 private:
  struct Slot {
    Corner corner;
    std::uint32_t index_plus_1;  // 0 is free
  };

  std::size_t SlotOf(const Corner& corner) const;
  std::uint32_t Find(const Corner& corner, std::size_t slot);
  void Grow();

  PointList points_;
  std::vector<Slot> slots_;  // the size is a power of two
  unsigned shift_ = 0;       // brings the high bits of a hash down to a slot
};

}  // namespace intaglio::mesh
