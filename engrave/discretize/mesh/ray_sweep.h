#pragma once

// The rows of a grid of rays, one after the other like the lines of a screen, with their
// crossings of some triangles. Only the triangles that a row meets are held at a time, so
// that they stay in the cache whatever the size of the mesh. Frame of the rays
// (ray_grid.h), mm.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/discretize/mesh/ray_grid.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

/// A vertex on a grid: u and v are multiples of its unit.
struct RayCorner {
  double u, v, w;
  std::uint32_t column, row;  ///< the first at it or behind it
};

/// The columns of a row, from begin to before end, that cross a triangle, and the heights
/// where they do.
struct RaySpan {
  std::uint32_t begin = 0, end = 0;
  double w_mm = 0, step_w_mm = 0;  ///< of the first, and from one to the next
};

class RaySweep {
 public:
  /// The arguments must outlive it.
  RaySweep(const RayGrid& grid, std::span<const RayCorner> corners,
           std::span<const mesh::Triangle> triangles);
  ~RaySweep();

  /// The rows that each triangle reaches, all together.
  double reached_row_count() const { return reached_row_count_; }

  /// The next row that reaches a triangle, from row 0 up; false when there is none.
  bool Next();
  std::uint32_t row() const { return row_; }
  /// Of this row, in no order.
  std::span<const RaySpan> spans() const { return {spans_.data(), span_count_}; }

 private:
  enum SideOf { kWhole, kLower, kUpper };
  struct Corners;
  struct Line;
  struct Met;
  Corners CornersOf(std::uint32_t triangle) const;
  void Meet(std::uint32_t triangle);
  void MeetTrianglesOf(std::uint32_t row);
  void SetSpans();
  std::uint32_t ColumnFrom(double at, const Met& met, SideOf side, double pv) const;
  std::int32_t ExactColumn(double at, const Met& met, SideOf side, double pv) const;
  void SetSlender(const Met& met, double pv, RaySpan& span) const;

  const RayGrid& grid_;
  double columns_per_mm_;
  std::span<const RayCorner> corners_;
  std::span<const mesh::Triangle> triangles_;
  double reached_row_count_ = 0;
  std::vector<std::uint32_t> first_;   // of each row, in by_row_
  std::vector<std::uint32_t> by_row_;  // triangles by their lowest row
  std::uint32_t row_ = 0, next_row_ = 0;
  std::vector<Met> met_;
  std::vector<std::uint32_t> in_row_, free_;  // in met_
  std::vector<RaySpan> spans_;
  std::size_t span_count_ = 0;
};

}  // namespace intaglio::discretize
