#pragma once

// Parallel rays ("Ray intersection", Trochimczuk 2008 ch. 6.1): rays on a square grid,
// and every crossing of the surface counts, front and back. Frame glass, mm.
//
// A ray through an edge or a vertex counts once (ray_caster.h): a closed mesh has an even
// number of crossings on every ray.

#include <memory>

#include "engrave/core/result.h"
#include "engrave/discretize/mesh/direction.h"
#include "engrave/discretize/spacing/point_source.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

struct RayOptions {
  double distance_mm = 1;  ///< side of the grid, 0.01..100
  Direction direction;
  /// Not the crossings, but points between each entry and its exit, the first, third and
  /// so on crossing of a ray and the next one: they divide the path in between into equal
  /// parts, none shorter than the distance, so along the ray they keep the distance from
  /// the surface, too. Rays with an odd number of crossings give none.
  bool interior_only = false;
  /// Whose axes the direction refers to: of the model its axes in the glass frame,
  /// columns; identity: of the block.
  Mat3 axes = Mat3::Identity();
  /// The grid goes through the block's origin, the same for all models, and not through
  /// the middle of the model.
  bool grid_through_origin = false;
};

/// The grid's centre is that of the model's extent, unless it goes through the origin:
/// then a model that lies between its rays gets none. Crossings are computed when a range
/// of heights is requested, from the triangles that reach into it; the insides of
/// interior_only are computed at once. Rays are counted with the lowest height of the
/// model. kTooLarge when the grid has more than 2^27 rays or there are too many crossings
/// or points (candidate_limit.h).
Result<std::unique_ptr<PointSource>> MakeRays(mesh::TriangleMesh mesh,
                                              const RayOptions& options);

}  // namespace intaglio::discretize
