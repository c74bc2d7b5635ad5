#pragma once

#include <cstdint>
#include <vector>

#include "engrave/discretize/mesh/surface_lattice.h"

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
  /// In the sequence in which their cubes were first used.
  const std::vector<Point>& points() const { return points_; }
  /// The range of heights of all cubes that the given one meets.
  HeightRange WholeCubes(const HeightRange& range) const;

 private:
  using Cube = std::array<std::int64_t, 3>;
  Cube CubeOf(const Vec3& p_mm) const;
  std::size_t SlotOf(const Cube& cube) const;
  void Grow();

  double side_mm_;
  std::vector<Point> points_;
  std::vector<Cube> cubes_;  // of each point
  // By open addressing: place in points_, + 1; 0 is free. The size is a power of two.
  std::vector<std::uint32_t> slots_;
};

/// Adds the corners that lie in the range.
void AddCorners(const Corners& corners, const std::array<bool, 3>& which,
                const HeightRange& range, std::uint32_t triangle, OnePerCube& points);

/// Adds points along the edges at equal parts of at most step_mm, the same for each
/// triangle of an edge.
void AddEdges(const Corners& corners, double step_mm, const HeightRange& range,
              std::uint32_t triangle, OnePerCube& points);

}  // namespace intaglio::discretize
