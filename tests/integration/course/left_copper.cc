#include "tests/integration/course/left_copper.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace intaglio::testing {

LeftCopper::LeftCopper(const std::vector<ToolStep>& work, double tool_radius_mm) {
  Vec2 low = Vec2::Constant(1e9), high = -low;
  for (const ToolStep& step : work) {
    low = low.cwiseMin(step.to_mm.head<2>());
    high = high.cwiseMax(step.to_mm.head<2>());
  }
  corner_mm_ = low - Vec2::Constant(3);
  const Vec2 size = high - low + Vec2::Constant(6);
  columns_ = static_cast<int>(size.x() / kCell_mm) + 1;
  rows_ = static_cast<int>(size.y() / kCell_mm) + 1;
  cells_.assign(static_cast<std::size_t>(columns_) * rows_, -1);
  for (const ToolStep& step : work) Sweep(step, tool_radius_mm);
  for (int row = 0; row < rows_; ++row)
    for (int column = 0; column < columns_; ++column)
      if (At(column, row) == -1) Fill(column, row);
}

void LeftCopper::Sweep(const ToolStep& step, double radius_mm) {
  const Vec2 from = step.from_mm.head<2>(), to = step.to_mm.head<2>();
  const Vec2 low = (from.cwiseMin(to) - corner_mm_).array() - radius_mm;
  const Vec2 high = (from.cwiseMax(to) - corner_mm_).array() + radius_mm;
  for (int row = static_cast<int>(low.y() / kCell_mm); row <= high.y() / kCell_mm; ++row)
    for (int column = static_cast<int>(low.x() / kCell_mm); column <= high.x() / kCell_mm;
         ++column)
      if (DistanceToStep(corner_mm_ + kCell_mm * Vec2(column, row), step) < radius_mm)
        At(column, row) = 0;
}

void LeftCopper::Fill(int column, int row) {
  const int island = ++islands_;
  std::vector<std::pair<int, int>> open = {{column, row}};
  At(column, row) = island;
  while (!open.empty()) {
    const auto [x, y] = open.back();
    open.pop_back();
    for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const int to_x = x + dx, to_y = y + dy;
      if (to_x < 0 || to_y < 0 || to_x >= columns_ || to_y >= rows_) continue;
      if (At(to_x, to_y) != -1) continue;
      At(to_x, to_y) = island;
      open.emplace_back(to_x, to_y);
    }
  }
}

int LeftCopper::IslandAt(const Vec2& place_mm) const {
  const Vec2 cell = (place_mm - corner_mm_) / kCell_mm;
  const auto column = std::lround(cell.x()), row = std::lround(cell.y());
  if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return 0;
  return cells_[static_cast<std::size_t>(row) * columns_ + column];
}

}  // namespace intaglio::testing
