#include "engrave/sort/near/near_points.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/sort/near/cell_grid.h"

namespace intaglio::sort {
namespace {

constexpr int kMaxRings = 3;

struct Found {
  float distance;
  std::uint32_t point;
  auto operator<=>(const Found&) const = default;
};

/// Those at most `rings` cells away.
void Collect(const CellGrid& grid, std::span<const Scaled> points, std::uint32_t point,
             int rings, std::vector<Found>& found) {
  const Scaled& here = points[point];
  const CellGrid::Cell c = grid.CellOf(here);
  grid.ForEachInCells(
      {c.x - rings, c.y - rings, c.z - rings}, {c.x + rings, c.y + rings, c.z + rings},
      [&](std::uint32_t i) {
        if (i == point) return true;
        const Scaled d = points[i] - here;
        found.push_back({std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}), i});
        return true;
      });
}

}  // namespace

NearPoints::NearPoints(std::span<const Scaled> points, std::size_t count, float typical)
    : begin_(points.size() + 1) {
  Require(typical > 0 && std::isfinite(typical), "typical must be positive, is {}",
          typical);
  if (points.empty()) return;
  const CellGrid grid(points, 1.5F * typical);
  std::vector<Found> found;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    for (int rings = 1; rings <= kMaxRings; ++rings) {
      found.clear();
      Collect(grid, points, i, rings, found);
      if (2 * found.size() > count) break;
    }
    const std::size_t kept = std::min(count, found.size());
    std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(kept),
                      found.end());
    for (std::size_t k = 0; k < kept; ++k) near_.push_back(found[k].point);
    begin_[i + 1] = static_cast<std::uint32_t>(near_.size());
  }
}

}  // namespace intaglio::sort
