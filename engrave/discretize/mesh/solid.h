#pragma once

// Points evenly throughout a volume: a face-centred cubic lattice, the densest one for a
// given minimum distance, with its layers horizontal. Glass frame.

#include <memory>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/discretize/spacing/point_source.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

struct SolidOptions {
  double distance_mm = 0.3;  ///< 0.01..100, of nearest points
  /// Factor on the distance of layers, 1..10: a crack is longer along the beam.
  double height_ratio = 1;
};

/// The lattice's nodes inside the closed surface (mm): those with an odd number of
/// crossings below them. A vertical line meets a shared edge or vertex once, so the
/// number is exact. Lines with an odd number of crossings in all, of which an open
/// surface has some, give no points and are counted. The crossings are found here: memory
/// grows with the surface, time of a range with its points and the surface's shadow.
/// Errors: kTooLarge and kCancelled.
Result<std::unique_ptr<PointSource>> MakeSolid(const mesh::TriangleMesh& mesh,
                                               const SolidOptions& options,
                                               const ProgressSink& progress = {});

}  // namespace intaglio::discretize
