#pragma once

// Clouds on which the sorters and the checker are tried. Seeded, so always the same.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::sort {

struct NamedCloud {
  std::string name;
  PointList points_mm;
};

inline PointList RandomBox(std::size_t count, const Vec3& size_mm, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  PointList points;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = unit(random);
    const double y = unit(random);
    points.emplace_back(size_mm.cwiseProduct(Vec3(x, y, unit(random))));
  }
  return points;
}

/// Random points of a dented sphere's surface, 40 mm across, in the middle of a block.
inline PointList DentedSphere(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  PointList points;
  while (points.size() < count) {
    const double x = normal(random);
    const double y = normal(random);
    const Vec3 v(x, y, normal(random));
    if (v.norm() < 1e-3) continue;
    const Vec3 u = v.normalized();
    const double radius_mm =
        18 * (1 + 0.2 * std::sin(5 * u.x()) * std::cos(4 * u.y() + 3 * u.z()));
    points.emplace_back(radius_mm * u + Vec3(50, 50, 50));
  }
  return points;
}

/// Every point of a grid, shuffled.
inline PointList Grid(int nx, int ny, int nz, double spacing_mm, double layer_mm,
                      std::uint32_t seed) {
  PointList points;
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        points.emplace_back(i * spacing_mm, j * spacing_mm, k * layer_mm);
      }
    }
  }
  std::shuffle(points.begin(), points.end(), std::mt19937(seed));
  return points;
}

/// Sections of a vase, a point every spacing along each.
inline PointList SlicedVase(int layers, double layer_mm, double spacing_mm) {
  PointList points;
  for (int k = 0; k < layers; ++k) {
    const double z_mm = k * layer_mm;
    const double radius_mm = 6 + 3 * std::sin(z_mm * 0.9);
    const int count = static_cast<int>(2 * std::numbers::pi * radius_mm / spacing_mm);
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * i / count;
      points.emplace_back(radius_mm * std::cos(angle), radius_mm * std::sin(angle), z_mm);
    }
  }
  return points;
}

/// Shapes that are hard in different ways, about `count` points each.
inline std::vector<NamedCloud> Clouds(std::size_t count) {
  const int side = static_cast<int>(std::cbrt(static_cast<double>(count)));
  PointList doubled = RandomBox(count / 4, {5, 5, 5}, 5);
  const PointList copy = doubled;
  for (int i = 0; i < 3; ++i) doubled.insert(doubled.end(), copy.begin(), copy.end());
  return {{"box", RandomBox(count, {10, 12, 9}, 1)},
          {"column", RandomBox(count, {1, 1, 60}, 2)},
          {"plate", RandomBox(count, {60, 60, 0.5}, 3)},
          {"sphere", DentedSphere(count, 4)},
          {"doubled", doubled},
          {"grid", Grid(side, side, side, 0.1, 0.1, 6)},
          {"flat grid", Grid(2 * side, 2 * side, std::max(1, side / 4), 0.25, 0.5, 7)},
          {"vase", SlicedVase(std::max(2, static_cast<int>(count) / 100), 0.1, 0.4)},
          {"far away", [count] {
             PointList points = RandomBox(count, {8, 8, 8}, 8);
             for (Vec3& p : points) p += Vec3(-5000, 3000, 1000);
             return points;
           }()}};
}

/// A straight row of points, a step each.
inline PointList Row(std::size_t count, const Vec3& step_mm) {
  PointList points;
  for (std::size_t i = 0; i < count; ++i) {
    points.emplace_back(static_cast<double>(i) * step_mm);
  }
  return points;
}

/// Clouds that are few, flat, thin or all in one place, by which something might be
/// divided or sorted by nothing.
inline std::vector<NamedCloud> DegenerateClouds() {
  PointList nearly_alike = RandomBox(60, {1e-41, 1e-41, 1e-41}, 10);
  PointList two_heaps(40, Vec3(1, 2, 3));
  two_heaps.insert(two_heaps.end(), 40, Vec3(1.05, 2, 3.4));
  std::vector<NamedCloud> clouds = {{"none", {}},
                                    {"300 alike", PointList(300, Vec3(7, 8, 9))},
                                    {"nearly alike", nearly_alike},
                                    {"two heaps", two_heaps},
                                    {"one height", RandomBox(300, {4, 4, 0}, 11)},
                                    {"row in x", Row(300, {0.1, 0, 0})},
                                    {"row in y", Row(300, {0, -0.07, 0})},
                                    {"row up", Row(300, {0, 0, 0.1})},
                                    {"row askew", Row(300, {0.03, 0.01, 0.02})}};
  for (int count = 1; count <= 7; ++count) {
    const auto size = static_cast<std::size_t>(count);
    clouds.push_back({std::to_string(count) + " alike", PointList(size, Vec3(1, 1, 1))});
    clouds.push_back(
        {std::to_string(count) + " in a box", RandomBox(size, {2, 2, 2}, 12)});
    clouds.push_back({std::to_string(count) + " up", Row(size, {0, 0, 0.3})});
  }
  return clouds;
}

}  // namespace intaglio::sort
