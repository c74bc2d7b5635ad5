#include "engrave/sort/near/cell_grid.h"

#include <limits>

#include "engrave/core/check.h"

namespace intaglio::sort {
namespace {

constexpr int kCellBits = 21;
constexpr std::int64_t kMaxCell = (std::int64_t{1} << kCellBits) - 2;

std::int64_t CellAlong(float cells) {
  const auto end = static_cast<float>(kMaxCell);
  return 1 + static_cast<std::int64_t>(std::clamp(cells, -1.0F, end));
}

}  // namespace

CellGrid::CellGrid(std::span<const Scaled> points, float cell) {
  Require(!points.empty(), "a grid without points");
  Scaled high = smallest_ = points[0];
  for (const Scaled& p : points) {
    smallest_ = {std::min(smallest_.x, p.x), std::min(smallest_.y, p.y),
                 std::min(smallest_.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Scaled size = high - smallest_;
  const float largest = std::max({size.x, size.y, size.z});
  // Not so small that its inverse would be infinite.
  per_cell_ = 1 / std::max({cell, largest / static_cast<float>(kMaxCell / 2),
                            std::numeric_limits<float>::min()});
  last_ = CellOf(high);
  by_cell_.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    by_cell_.emplace_back(KeyOf(CellOf(points[i])), i);
  }
  std::sort(by_cell_.begin(), by_cell_.end());
}

CellGrid::Cell CellGrid::CellOf(const Scaled& place) const {
  const Scaled d = place - smallest_;
  return {CellAlong(d.x * per_cell_), CellAlong(d.y * per_cell_),
          CellAlong(d.z * per_cell_)};
}

std::uint64_t CellGrid::KeyOf(const Cell& cell) {
  return (static_cast<std::uint64_t>(cell.x) << (2 * kCellBits)) |
         (static_cast<std::uint64_t>(cell.y) << kCellBits) |
         static_cast<std::uint64_t>(cell.z);
}

}  // namespace intaglio::sort
