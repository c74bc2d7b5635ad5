#pragma once

// Points sorted by the cell of a grid that they are in. The cells above one another
// follow each other there, so a column of them is found with one search.

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "engrave/sort/near/tick_cost.h"

namespace intaglio::sort {

class CellGrid {
 public:
  struct Cell {
    std::int64_t x, y, z;
  };

  /// points: at least one. cell: a cell's side, > 0; where
  /// the cloud is too large for it, cells are larger.
  CellGrid(std::span<const Scaled> points, float cell);

  /// The cell of a place; a place outside of the cloud's box belongs to a cell beside it.
  Cell CellOf(const Scaled& place) const;

  /// Calls take(index) for every point in the cells from `low` to `high`, both included,
  /// until it returns false. Returns whether it never did.
  template <typename Take>
  bool ForEachInCells(const Cell& low, const Cell& high, Take&& take) const {
    const std::int64_t first = std::max<std::int64_t>(low.z, 0);
    for (std::int64_t x = std::max<std::int64_t>(low.x, 1);
         x <= std::min(high.x, last_.x); ++x) {
      for (std::int64_t y = std::max<std::int64_t>(low.y, 1);
           y <= std::min(high.y, last_.y); ++y) {
        const std::uint64_t end = KeyOf({x, y, std::min(high.z, last_.z)});
        auto i = std::lower_bound(by_cell_.begin(), by_cell_.end(),
                                  std::pair(KeyOf({x, y, first}), 0U));
        for (; i != by_cell_.end() && i->first <= end; ++i) {
          if (!take(i->second)) return false;
        }
      }
    }
    return true;
  }

 private:
  static std::uint64_t KeyOf(const Cell& cell);

  Scaled smallest_;
  float per_cell_ = 1;
  Cell last_ = {1, 1, 1};  ///< Of the cloud's upper corner.
  std::vector<std::pair<std::uint64_t, std::uint32_t>> by_cell_;
};

}  // namespace intaglio::sort
