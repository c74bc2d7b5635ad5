#pragma once

// Parallel rays ("Ray intersection", Trochimczuk 2008 ch. 6.1): rays on a square grid,
// and every crossing of the surface counts, front and back. Frame glass, mm.
//
// The triangles are converted onto the grid of rays, as a screen is drawn. A ray through
// an edge or a vertex counts once: it is taken as moved aside by an infinitesimal step,
// the same for all triangles, and the side of an edge on which it passes is decided
// exactly. So a closed mesh has an even number of crossings on every ray.

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/discretize/direction.h"
#include "engrave/discretize/statistics.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

struct RayOptions {
  double distance_mm = 1;  ///< side of the grid, 0.01..100
  Direction direction;
};

/// Appends to `cloud`, ray by ray, each from its lowest crossing up. The grid's centre is
/// that of the model's extent. kTooLarge when the grid has more than 2^27 rays or there
/// are too many crossings (candidate_limit.h); kCancelled when `progress` says so.
Result<MethodStatistics> CrossRays(const mesh::TriangleMesh& mesh,
                                   const RayOptions& options, std::uint32_t source,
                                   const ProgressSink& progress, PointCloud& cloud);

}  // namespace intaglio::discretize
