#pragma once

#include <cstdint>
#include <vector>

#include "engrave/discretize/surface_lattice.h"

namespace intaglio::discretize {

/// Points thinned to one for each cube of a grid: a vertex rather than a point of an
/// edge, then the lowest, by z, y, x and the number of its triangle, so that the result
/// does not depend on the sequence.
class OnePerCube {
 public:
  struct Point {
    Vec3 p_mm;
    std::uint32_t triangle;
    bool on_edge;  ///< and no vertex
  };

  explicit OnePerCube(double side_mm);

  void Add(const Point& point);
  /// In the sequence in which their cubes were met first.
  const std::vector<Point>& points() const { return points_; }
  /// The range of heights of all cubes that the given one meets.
  HeightRange WholeCubes(const HeightRange& range) const;

 private:
  std::size_t SlotOf(const Point& point) const;
  void Grow();
  std::array<std::int64_t, 3> CubeOf(const Vec3& p_mm) const;

  double side_mm_;
  std::vector<Point> points_;
  // By open addressing: place in points_, + 1; 0 is free. The size is a power of two.
  std::vector<std::uint32_t> slots_;
};

/// Adds the triangle's corners, and along the edges if `edges` points at equal parts of
/// at most step_mm, the same for each triangle of an edge.
void AddOwnPoints(const Corners& corners, bool edges, double step_mm,
                  const HeightRange& range, std::uint32_t triangle, OnePerCube& points);

}  // namespace intaglio::discretize
