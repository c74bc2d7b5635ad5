#pragma once

// The copper that a tool leaves of a board, by cells of 0.02 mm: a judge of isolations
// that shares nothing with engrave/contour. Frame: the machine's axes, mm.

#include <vector>

#include "tests/integration/course/tool_way.h"

namespace intaglio::testing {

class LeftCopper {
 public:
  /// The copper of the sheet around `work`, 3 mm wider on each side.
  LeftCopper(const std::vector<ToolStep>& work, double tool_radius_mm);

  /// Number of the island, from 1; 0: there is no copper.
  int IslandAt(const Vec2& place_mm) const;
  int island_count() const { return islands_; }

 private:
  static constexpr double kCell_mm = 0.02;
  int& At(int column, int row) {
    return cells_[static_cast<std::size_t>(row) * columns_ + column];
  }
  void Sweep(const ToolStep& step, double radius_mm);
  void Fill(int column, int row);

  Vec2 corner_mm_ = Vec2::Zero();
  int columns_ = 0, rows_ = 0, islands_ = 0;
  std::vector<int> cells_;  ///< -1: not yet visited
};

}  // namespace intaglio::testing
