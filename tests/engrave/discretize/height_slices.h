#pragma once

// How many points lie in level slices of a surface, by how many its area lets expect.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

/// The area of a triangle below a height. Between its lowest and its middle corner the
/// area grows with the square of the height, above that the area that is missing shrinks
/// so.
inline double AreaBelow(std::array<Vec3, 3> t, double z_mm) {
  std::sort(t.begin(), t.end(),
            [](const Vec3& a, const Vec3& b) { return a.z() < b.z(); });
  const double area_mm2 = 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm();
  const double low = t[0].z(), middle = t[1].z(), high = t[2].z();
  if (z_mm >= high) return area_mm2;
  if (z_mm <= low) return 0;
  if (z_mm < middle) {
    return area_mm2 * (z_mm - low) * (z_mm - low) / ((middle - low) * (high - low));
  }
  const double above = (high - z_mm) * (high - z_mm) / ((high - low) * (high - middle));
  return area_mm2 * (1 - above);
}

struct SliceRatio {
  double low_mm;
  double ratio;  ///< of points to those expected
};

/// Counts the slices of this thickness, from the lowest point of the mesh up, in which at
/// least min_expected points are expected: of all points as many as it has of the area. A
/// level face is in the slice that holds its height.
inline std::vector<SliceRatio> SliceRatios(const mesh::TriangleMesh& mesh,
                                           const PointList& points, double slice_mm,
                                           double min_expected = 40) {
  const Box3 bounds = mesh.Bounds();
  const double base_mm = bounds.min_mm.z();
  const auto slice_of = [&](double z_mm) {
    return static_cast<std::size_t>(std::max(0.0, (z_mm - base_mm) / slice_mm));
  };
  std::vector<double> areas_mm2(slice_of(bounds.max_mm.z()) + 1),
      counts(areas_mm2.size());
  double all_mm2 = 0;
  for (const mesh::Triangle& triangle : mesh.triangles) {
    const std::array<Vec3, 3> t = {mesh.vertices[triangle[0]], mesh.vertices[triangle[1]],
                                   mesh.vertices[triangle[2]]};
    const auto [low, high] = std::minmax({t[0].z(), t[1].z(), t[2].z()});
    const double area_mm2 = AreaBelow(t, high);
    all_mm2 += area_mm2;
    double below_mm2 = 0;
    for (std::size_t i = slice_of(low); i <= slice_of(high); ++i) {
      const double top_mm = base_mm + slice_mm * static_cast<double>(i + 1);
      const double next_mm2 = i == slice_of(high) ? area_mm2 : AreaBelow(t, top_mm);
      areas_mm2[i] += next_mm2 - below_mm2;
      below_mm2 = next_mm2;
    }
  }
  for (const Vec3& p : points) {
    ++counts[std::min(slice_of(p.z()), counts.size() - 1)];
  }
  std::vector<SliceRatio> ratios;
  for (std::size_t i = 0; i < areas_mm2.size(); ++i) {
    const double expected = static_cast<double>(points.size()) * areas_mm2[i] / all_mm2;
    if (expected < min_expected) continue;
    ratios.push_back({base_mm + slice_mm * static_cast<double>(i), counts[i] / expected});
  }
  return ratios;
}

}  // namespace intaglio::discretize
