#pragma once

// The quality of the points of a job, measured by code that shares nothing with the code
// that made them: how even they are, how they cover the surface, and where the glass may
// break.

#include <cstdint>
#include <optional>
#include <vector>

#include "engrave/core/executor.h"
#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "engrave/mesh/mesh.h"
#include "engrave/proof/crack_risk.h"
#include "engrave/proof/height_slices.h"
#include "engrave/proof/nearest_distances.h"
#include "engrave/proof/surface_density.h"
#include "engrave/proof/uncovered_disc.h"

namespace intaglio::proof {

struct QualityOptions {
  double min_spacing_mm = 0;  ///< as requested, positive
  double height_ratio = 1;    ///< >= 1: heights count only by this part of them
  /// Of the machine's lens; both 0: the risk of cracks is not reported.
  double crack_diameter_mm = 0, crack_length_mm = 0;
  Executor executor = {};
};

struct SurfaceQuality {
  std::uint64_t triangle_count = 0;
  UncoveredDisc uncovered;
  SurfaceDensity density;
  /// Of the density, in the densest possible: hexagonal, at the minimum spacing.
  double density_ratio = 0;
  Vec3 farthest_mm = Vec3::Zero();  ///< the point farthest from the surface
  /// Nothing when more than a few points are off the surface, or no slice counts.
  std::optional<HeightSlices> slices;
};

struct SourceShare {
  std::uint32_t source = 0;
  std::uint64_t point_count = 0;
  double point_ratio = 0;               ///< of all points
  std::optional<double> surface_ratio;  ///< its model's part of the whole surface
};

struct CloudQuality {
  std::uint64_t point_count = 0;
  Box3 bounds_mm;
  NearestDistances nearest;
  Histogram histogram;  ///< in parts of the minimum spacing
  std::vector<SourceShare> sources;
  std::optional<SurfaceQuality> surface;  ///< when there are models
  std::optional<CrackRisk> crack_risk;    ///< when there is a crack's size
  Warnings warnings;

  bool KeepsSpacing() const {
    return nearest.doubled_count == 0 && nearest.near_pair_count == 0;
  }
};

/// Frame glass, mm, finite; `models` are placed, source i of the cloud is models[i] if
/// there is such a one. The same for any executor. kMissing: the cloud has no points, or
/// the models have no triangles.
Result<CloudQuality> MeasureCloud(const PointCloud& cloud,
                                  const std::vector<mesh::TriangleMesh>& models,
                                  const QualityOptions& options);

}  // namespace intaglio::proof
