#pragma once

// The faces of a mesh that lie parallel to a stack of planes, which do not cut them, and
// their fill. Frame glass, mm.

#include <cstdint>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

struct FlatFaces {
  std::vector<mesh::Triangle> triangles;
  std::uint64_t face_count = 0;  ///< sets of them that hang together by edges
  double area_mm2 = 0;
  /// Of all other triangles, seen parallel to the planes: the length of their contours
  /// times the distance of the planes.
  double wall_area_mm2 = 0;
};

/// Within 0.1 degrees of being perpendicular to `normal` (of length 1). `neighbours`:
/// EdgeNeighbours(mesh).
FlatFaces FindFlatFaces(const mesh::TriangleMesh& mesh,
                        const std::vector<std::uint32_t>& neighbours, const Vec3& normal);

/// Points on the faces at the corners of equilateral triangles of this side, one grid for
/// all: so no edge between triangles shows. `frame`: columns u, v, w, the last across the
/// faces. kTooLarge for more than ray_grid.h and candidate_limit.h allow.
Result<PointList> CoverFlatFaces(const FlatFaces& faces, const PointList& vertices,
                                 const Mat3& frame, double distance_mm);

}  // namespace intaglio::discretize
