#pragma once

// Which rays of a grid cross which triangles, and where. The triangles are converted onto
// the grid as a screen is drawn. A ray through an edge or a vertex counts once: it is
// taken as moved aside by an infinitesimal step, the same for all triangles, and the side
// of an edge on which it passes is decided exactly. So a closed mesh has an even number
// of crossings on every ray. Frame of the rays (ray_grid.h), mm.

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "engrave/discretize/ray_grid.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

/// The columns of a row, from begin to before end, that cross a triangle, and the heights
/// where they do.
struct RaySpan {
  std::uint32_t begin = 0, end = 0;
  double w_mm = 0, step_w_mm = 0;  ///< of the first, and from one to the next
};

class RaySpans {
 public:
  std::uint64_t crossing_count() const { return crossing_count_; }

  /// Calls visit(column, row, heights) for each ray that crosses anything, with a span of
  /// the heights (double) of its crossings from the lowest up.
  template <typename Visit>
  void ForEachRay(const Visit& visit) const;

 private:
  friend class RayCaster;
  std::uint64_t crossing_count_ = 0;
  std::uint32_t column_count_ = 0;
  std::vector<std::uint32_t> row_begin_, row_end_;  // in spans_
  std::vector<RaySpan> spans_;
};

class RayCaster {
 public:
  /// Vertices in the rays' frame.
  RayCaster(const RayGrid& grid, const PointList& vertices);

  /// Of these triangles. kTooLarge when their crossings, or the rows that they reach, are
  /// more than candidate_limit.h allows. May be called from several threads at once.
  Result<RaySpans> Cast(std::span<const mesh::Triangle> triangles) const;

  const RayGrid& grid() const { return grid_; }

 private:
  struct Corner {
    double u, v, w;             // u and v multiples of the grid's unit
    std::uint32_t column, row;  // the first at it or behind it
  };
  class Side;
  class Slope;
  bool Misses(const mesh::Triangle& triangle) const;
  void CastOne(const mesh::Triangle& triangle, RaySpans& spans) const;

  RayGrid grid_;
  std::vector<Corner> corners_;
};

template <typename Visit>
void RaySpans::ForEachRay(const Visit& visit) const {
  // What was the beginning of a column's heights is their end when all are in.
  std::vector<std::uint32_t> end_of(column_count_ + 1, 0);
  std::vector<double> heights;
  for (std::uint32_t row = 0; row < row_begin_.size(); ++row) {
    const std::span<const RaySpan> spans(spans_.data() + row_begin_[row],
                                         spans_.data() + row_end_[row]);
    if (spans.empty()) continue;
    // Crossings of each column, from their differences.
    std::fill(end_of.begin(), end_of.end(), 0U);
    std::uint32_t first = column_count_, last = 0;
    for (const RaySpan& span : spans) {
      ++end_of[span.begin];
      --end_of[span.end];
      first = std::min(first, span.begin);
      last = std::max(last, span.end);
    }
    std::uint32_t count = 0, total = 0;
    for (std::uint32_t column = first; column < last; ++column) {
      count += end_of[column];
      end_of[column] = total;
      total += count;
    }
    if (heights.size() < total) heights.resize(total);
    for (const RaySpan& span : spans) {
      double w_mm = span.w_mm;
      for (std::uint32_t column = span.begin; column < span.end; ++column) {
        heights[end_of[column]++] = w_mm;
        w_mm += span.step_w_mm;
      }
    }
    std::uint32_t from = 0;
    for (std::uint32_t column = first; column < last; ++column) {
      const std::uint32_t to = end_of[column];
      if (from == to) continue;
      const std::span<double> ray(heights.data() + from, to - from);
      if (ray.size() > 2) {
        std::sort(ray.begin(), ray.end());
      } else if (ray.size() == 2 && ray[1] < ray[0]) {
        std::swap(ray[0], ray[1]);
      }
      visit(column, row, std::span<const double>(ray));
      from = to;
    }
  }
}

}  // namespace intaglio::discretize
