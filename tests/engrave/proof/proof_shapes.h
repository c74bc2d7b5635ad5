#pragma once

// Surfaces and clouds whose measures are known without measuring.

#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <thread>
#include <vector>

#include "engrave/core/executor.h"
#include "engrave/core/geometry.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::proof {

/// The rectangle 0..width, 0..depth at the height z, cut into `cells` each way and
/// each cell into two triangles.
inline mesh::TriangleMesh Rectangle(double width_mm, double depth_mm, double z_mm,
                                    std::uint32_t cells) {
  mesh::TriangleMesh mesh;
  for (std::uint32_t j = 0; j <= cells; ++j) {
    for (std::uint32_t i = 0; i <= cells; ++i) {
      mesh.vertices.emplace_back(width_mm * i / cells, depth_mm * j / cells, z_mm);
    }
  }
  const std::uint32_t row = cells + 1;
  for (std::uint32_t j = 0; j < cells; ++j) {
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t a = j * row + i;
      mesh.triangles.push_back({a, a + 1, a + row + 1});
      mesh.triangles.push_back({a, a + row + 1, a + row});
    }
  }
  return mesh;
}

/// The surface of the cube 0..size.
inline mesh::TriangleMesh Cube(double size_mm) {
  mesh::TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.push_back(size_mm * Vec3(i & 1, i >> 1 & 1, i >> 2 & 1));
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// The hexagonal lattice with this spacing over a rectangle and a little beyond.
inline PointList HexagonalLattice(double width_mm, double depth_mm, double z_mm,
                                  double spacing_mm) {
  PointList points;
  const double row_mm = spacing_mm * std::numbers::sqrt3 / 2;
  for (int j = -2; j * row_mm < depth_mm + 2 * row_mm; ++j) {
    for (int i = -2; i * spacing_mm < width_mm + 2 * spacing_mm; ++i) {
      points.emplace_back((i + 0.5 * (j & 1)) * spacing_mm, j * row_mm, z_mm);
    }
  }
  return points;
}

inline PointList RandomPoints(int count, double size_mm, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(0, size_mm);
  PointList points;
  for (int i = 0; i < count; ++i) {
    const double x = coordinate(random), y = coordinate(random), z = coordinate(random);
    points.emplace_back(x, y, z);
  }
  return points;
}

/// Every task on a thread of its own, the last one first.
inline Executor Scattered() {
  return [](std::size_t count, const std::function<void(std::size_t)>& work) {
    std::vector<std::jthread> threads;
    for (std::size_t i = count; i-- > 0;) threads.emplace_back([&work, i] { work(i); });
  };
}

}  // namespace intaglio::proof
