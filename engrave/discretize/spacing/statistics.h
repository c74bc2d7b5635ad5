#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

namespace intaglio::discretize {

/// Layers and rays are this much farther apart than requested, a thousandth of a
/// micrometre over a whole block. Without it rounding could bring points that are exactly
/// the minimum spacing apart nearer than that, and thinning would remove every second
/// one.
inline constexpr double kRoundingAllowance = 1 + 1e-9;

/// The spacing of a point in single precision, as clouds have it: not below the given
/// one. A lattice whose nodes are exactly that far apart is made of this number.
inline float UpwardSingle(double spacing_mm) {
  const auto single = static_cast<float>(spacing_mm);
  if (static_cast<double>(single) >= spacing_mm) return single;
  return std::nextafter(single, std::numeric_limits<float>::infinity());
}

/// The statistics of a method on one model.
struct MethodStatistics {
  std::uint64_t point_count = 0;              ///< before thinning
  std::uint64_t plane_count = 0;              ///< sections
  std::uint64_t closed_contour_count = 0;     ///< sections
  std::uint64_t open_contour_count = 0;       ///< sections: they end at open edges
  std::uint64_t parallel_face_count = 0;      ///< sections: faces that no plane can cut
  double parallel_area_mm2 = 0;               ///< of them
  std::uint64_t small_triangle_count = 0;     ///< fill: smaller than a point
  std::uint64_t rejected_triangle_count = 0;  ///< fill: without area
  std::uint64_t shallow_count = 0;  ///< even: of shells, where the model is too thin
  std::uint64_t ray_count = 0;      ///< rays that meet the model
  std::uint64_t odd_ray_count = 0;  ///< of them, with an odd number of crossings

  void Add(const MethodStatistics& other) {
    point_count += other.point_count;
    plane_count += other.plane_count;
    closed_contour_count += other.closed_contour_count;
    open_contour_count += other.open_contour_count;
    parallel_face_count += other.parallel_face_count;
    parallel_area_mm2 += other.parallel_area_mm2;
    small_triangle_count += other.small_triangle_count;
    rejected_triangle_count += other.rejected_triangle_count;
    shallow_count += other.shallow_count;
    ray_count += other.ray_count;
    odd_ray_count += other.odd_ray_count;
  }
};

}  // namespace intaglio::discretize
