#include "engrave/sort/near_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engrave/core/check.h"

// Points are sorted by the cell of a grid that they are in. The cells above one another
// follow each other there, so a column of them is found with one search.

namespace intaglio::sort {
namespace {

constexpr int kBits = 21;
constexpr std::int64_t kMaxCell = (std::int64_t{1} << kBits) - 2;
constexpr int kMaxRings = 3;

struct Cell {
  std::int64_t x, y, z;
};

struct Found {
  float distance;
  std::uint32_t point;
  auto operator<=>(const Found&) const = default;
};

class Grid {
 public:
  Grid(std::span<const Scaled> points, float cell) : points_(points) {
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
    for (std::uint32_t i = 0; i < points.size(); ++i) {
      by_cell_.emplace_back(KeyOf(CellOf(points[i])), i);
    }
    std::sort(by_cell_.begin(), by_cell_.end());
  }

  /// Those at most `rings` cells away.
  void Collect(std::uint32_t point, int rings, std::vector<Found>& found) const {
    const Scaled& here = points_[point];
    const Cell c = CellOf(here);
    for (std::int64_t x = c.x - rings; x <= c.x + rings; ++x) {
      for (std::int64_t y = c.y - rings; y <= c.y + rings; ++y) {
        if (x < 1 || y < 1 || x > kMaxCell || y > kMaxCell) continue;
        const std::uint64_t last = KeyOf({x, y, c.z + rings});
        auto i = std::lower_bound(
            by_cell_.begin(), by_cell_.end(),
            std::pair(KeyOf({x, y, std::max<std::int64_t>(c.z - rings, 0)}), 0U));
        for (; i != by_cell_.end() && i->first <= last; ++i) {
          if (i->second == point) continue;
          const Scaled d = points_[i->second] - here;
          found.push_back(
              {std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)}), i->second});
        }
      }
    }
  }

 private:
  /// From 1 on, so that a ring fits around every cell.
  Cell CellOf(const Scaled& p) const {
    const Scaled d = p - smallest_;
    return {1 + static_cast<std::int64_t>(d.x * per_cell_),
            1 + static_cast<std::int64_t>(d.y * per_cell_),
            1 + static_cast<std::int64_t>(d.z * per_cell_)};
  }
  static std::uint64_t KeyOf(const Cell& c) {
    return (static_cast<std::uint64_t>(c.x) << (2 * kBits)) |
           (static_cast<std::uint64_t>(c.y) << kBits) | static_cast<std::uint64_t>(c.z);
  }

  std::span<const Scaled> points_;
  Scaled smallest_;
  float per_cell_ = 1;
  std::vector<std::pair<std::uint64_t, std::uint32_t>> by_cell_;
};

}  // namespace

NearPoints::NearPoints(std::span<const Scaled> points, std::size_t count, float typical)
    : begin_(points.size() + 1) {
  Require(typical > 0 && std::isfinite(typical), "typical must be positive, is {}",
          typical);
  if (points.empty()) return;
  const Grid grid(points, 1.5F * typical);
  std::vector<Found> found;
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    for (int rings = 1; rings <= kMaxRings; ++rings) {
      found.clear();
      grid.Collect(i, rings, found);
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
