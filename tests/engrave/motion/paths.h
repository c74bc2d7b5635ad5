#pragma once

// Paths and clouds that the benchmarks and the measured tables are made with.

#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>

#include "engrave/core/geometry.h"

namespace intaglio {

/// A cloud or order of tests/data/clouds: "calibrated_ordered" or "scatter", mm.
inline PointList FittedPoints(const std::string& name) {
  std::ifstream file(INTAGLIO_SOURCE_DIR "/tests/data/clouds/" + name + ".xyz");
  PointList points_mm;
  for (std::string line; std::getline(file, line);) {
    std::istringstream numbers(line);
    Vec3 p;
    if (numbers >> p.x() >> p.y() >> p.z()) points_mm.push_back(p);
  }
  return points_mm;
}

/// A sphere in level sections, each contour passed in turn from the lowest on: how an
/// order by layers goes over a smooth surface.
inline PointList SphereContours(double radius_mm, double layer_mm, double spacing_mm) {
  PointList points_mm;
  const int layers = static_cast<int>(2 * radius_mm / layer_mm);
  for (int k = 0; k < layers; ++k) {
    const double z_mm = -radius_mm + (k + 0.5) * layer_mm;
    const double r_mm = std::sqrt(radius_mm * radius_mm - z_mm * z_mm);
    const int count =
        std::max(1, static_cast<int>(2 * std::numbers::pi * r_mm / spacing_mm));
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * i / count;
      points_mm.emplace_back(r_mm * std::cos(angle), r_mm * std::sin(angle), z_mm);
    }
  }
  return points_mm;
}

}  // namespace intaglio
