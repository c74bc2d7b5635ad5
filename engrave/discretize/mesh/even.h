#pragma once

// Even sampling: points all over a surface, each at least a distance from the next and no
// place much farther than that from one (blue noise; Poisson disc sampling, Cook 1986),
// on shells below it if wanted, and denser or sparser from place to place. Glass frame.
//
// The method offers about 25 candidates for each point that remains; the weld (weld.h)
// chooses from the lowest up, which packs evenly.

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

/// Mesh in mm, its triangles counter-clockwise from outside, which shells and light
/// depend on. Shells are left out where the model is too thin for them: the statistics
/// tell how many of their candidates.
Result<std::unique_ptr<PointSource>> MakeEven(mesh::TriangleMesh mesh,
                                              const EvenOptions& options);

}  // namespace intaglio::discretize
