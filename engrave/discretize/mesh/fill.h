#pragma once

// Triangle fill ("Filling faces", Trochimczuk 2008 annex B): points at equal spacing on
// every triangle. The source's points crowd where triangles meet and miss small
// triangles; here the triangles share lattices of candidates (surface_grid.h), a small
// triangle contributes through its neighbourhood, and thinning (weld.h) keeps as many
// candidates as fit. Glass frame, mm.

#include <memory>

#include "engrave/core/result.h"
#include "engrave/discretize/spacing/point_source.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

struct FillOptions {
  double vertex_distance_mm = 1;  ///< 0.01..100; established by thinning
  /// Candidates on edges and vertices, too: boundaries show.
  bool full_fill = true;
};

/// Its statistics count the triangles without area, which are omitted, and those with no
/// edge as long as a quarter of the distance. The own spacing of the points is the
/// distance, so thinning keeps them at least that far apart.
Result<std::unique_ptr<PointSource>> MakeFill(mesh::TriangleMesh mesh,
                                              const FillOptions& options);

}  // namespace intaglio::discretize
