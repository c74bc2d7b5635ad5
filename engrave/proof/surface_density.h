#pragma once

// How a cloud lies on its surface: how far its points are from it, and how evenly they
// are spread over it.

#include <cstdint>

#include "engrave/core/executor.h"
#include "engrave/core/geometry.h"
#include "engrave/proof/surface.h"

namespace intaglio::proof {

struct SurfaceDensityOptions {
  /// Points farther from the surface than this do not count as points on it: they fill
  /// the inside, or lie on shells beneath. Positive.
  double reach_mm = 0;
  /// The surface is divided into patches of equal area, so many that each would have this
  /// number of points on average. A surface of random points would vary by 1 / sqrt of
  /// it.
  std::uint32_t points_per_patch = 100;
  Executor executor = {};
};

struct SurfaceDensity {
  double area_mm2 = 0;
  std::uint64_t on_surface_count = 0;
  double points_per_mm2 = 0;  ///< of those on the surface
  std::uint64_t patch_count = 0;
  /// Standard deviation over mean of the points per mm^2 in the patches; 0: the same
  /// everywhere, as requested.
  double variation_ratio = 0;
  std::uint64_t empty_patch_count = 0;

  // Over all points, and over those on the surface.
  double greatest_distance_mm = 0;
  std::uint32_t farthest_point = 0;
  double greatest_on_surface_mm = 0;
};

/// The minimum area to which Surface should cut its triangles for these options, mm^2.
double PieceArea(double area_mm2, std::uint64_t point_count,
                 const SurfaceDensityOptions& options);

/// `points_mm`, at least one, best in an order of neighbours (distinct_places.h). The
/// same for any executor.
SurfaceDensity MeasureSurfaceDensity(const Surface& surface, const PointList& points_mm,
                                     const SurfaceDensityOptions& options);

}  // namespace intaglio::proof
