#pragma once

// Cells of a grid in a given number of dimensions, as keys of an unordered_map: places
// near each other are in the same cell or in neighbouring ones.

#include <array>
#include <cstddef>
#include <cstdint>

namespace intaglio::curve {

template <std::size_t kDimensions>
using Cell = std::array<std::int64_t, kDimensions>;

struct CellHash {
  template <std::size_t kDimensions>
  std::size_t operator()(const Cell<kDimensions>& cell) const {
    std::uint64_t hash = 0;
    for (const std::int64_t part : cell) {
      hash = (hash ^ static_cast<std::uint64_t>(part)) * 0x9E3779B97F4A7C15ULL;
      hash ^= hash >> 29;
    }
    return hash;
  }
};

}  // namespace intaglio::curve
