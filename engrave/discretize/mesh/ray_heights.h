#pragma once

// The crossings of a row of rays, ray by ray, computed from the row's crossings with
// triangles (ray_sweep.h). Frame of the rays, mm.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "engrave/discretize/mesh/ray_sweep.h"

namespace intaglio::discretize {

class RayHeights {
 public:
  explicit RayHeights(std::uint32_t column_count) : end_of_(column_count + 1, 0) {}

  /// Clears the previous row. The number of crossings of this row.
  std::uint32_t Receive(std::span<const RaySpan> spans);

  /// Calls visit(column, heights) for each ray of the row that crosses anything, by
  /// columns, with a span of the heights (double) from the lowest up.
  template <typename Visit>
  void ForEachRay(const Visit& visit);

 private:
  // Once all heights of a column are stored, the entry for their beginning holds their
  // end.
  std::vector<std::uint32_t> end_of_;
  std::vector<double> heights_;
  std::uint32_t first_ = 0, last_ = 0;  // columns
};

template <typename Visit>
void RayHeights::ForEachRay(const Visit& visit) {
  std::uint32_t from = 0;
  for (std::uint32_t column = first_; column < last_; ++column) {
    const std::uint32_t to = end_of_[column];
    if (from == to) continue;
    const std::span<double> ray(heights_.data() + from, to - from);
    if (ray.size() == 2) {
      // Most have two, in either order, so a branch could not be predicted.
      const double low = std::min(ray[0], ray[1]), high = std::max(ray[0], ray[1]);
      ray[0] = low;
      ray[1] = high;
    } else if (ray.size() > 2) {
      std::sort(ray.begin(), ray.end());
    }
    visit(column, std::span<const double>(ray));
    from = to;
  }
}

}  // namespace intaglio::discretize
