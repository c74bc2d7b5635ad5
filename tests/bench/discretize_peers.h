#pragma once

// Other programs and libraries at the work of discretization, where they are installed.

#include <functional>
#include <optional>
#include <string>

#include "engrave/core/geometry.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::bench {

/// The result of a peer, and its best time of a few runs.
struct PeerRun {
  double ms = 0;
  double count = 0;  ///< contours, hits or points; 0 where the peer does not report it
};

/// The shortest wall time of `runs` calls, ms.
double BestMs(int runs, const std::function<void()>& work);

/// CuraEngine's own figures of its slices and their polygons, without its adjacency,
/// which it makes as it loads the file. On one core.
std::optional<PeerRun> CuraSlices(const mesh::TriangleMesh& mesh, double layer_mm);

/// CGAL's Polygon_mesh_slicer with its tree.
std::optional<PeerRun> CgalSlices(const mesh::TriangleMesh& mesh, double first_mm,
                                  double layer_mm, std::size_t count);

/// Embree, robust, packets of 16 started anew behind every hit; with its tree. The rays
/// start at origin + i across_u + j across_v for i < columns, j < rows.
struct RayBundle {
  Vec3 origin_mm, across_u_mm, across_v_mm, direction;
  int columns = 0, rows = 0;
};
std::optional<PeerRun> EmbreeRays(const mesh::TriangleMesh& mesh, const RayBundle& rays);

/// CloudCompare's spatial subsampling: a run that loads and samples less one that loads.
std::optional<PeerRun> CloudCompareThinning(const PointList& points_mm,
                                            double spacing_mm);

}  // namespace intaglio::bench
