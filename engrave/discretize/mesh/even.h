#pragma once

// Even sampling: points all over a surface, at least a given distance apart, with no
// place of the surface much farther than that distance from a point (blue noise; Poisson
// disc sampling, Cook 1986). Optional: shells below the surface, and a density that
// varies over it. Glass frame.
//
// The method offers about 25 candidates for each point that remains; thinning
// (thinning.h) selects along ObliqueRise(), which packs evenly and leaves no level rows.

#include <memory>
#include <vector>

#include "engrave/discretize/mesh/density.h"
#include "engrave/discretize/spacing/point_source.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

struct EvenOptions {
  double distance_mm = 0.1;  ///< 0.01..100, of nearest points; where it is densest
  /// At least distance_mm, where it is sparsest; of no effect without a density.
  double sparse_distance_mm = 0.3;
  Density density = {};                ///< empty: distance_mm everywhere
  bool surface = true;                 ///< points on the surface itself
  std::vector<double> depths_mm = {};  ///< > 0: shells so far below the surface, inward
};

/// Mesh in mm. Its triangles must be counter-clockwise seen from outside; shells and
/// light depend on that. Shells are omitted where the model is too thin for them; the
/// statistics count the omitted candidates.
Result<std::unique_ptr<PointSource>> MakeEven(mesh::TriangleMesh mesh,
                                              const EvenOptions& options);

}  // namespace intaglio::discretize
