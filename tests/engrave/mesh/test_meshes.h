#pragma once

#include "engrave/mesh/mesh.h"

namespace intaglio::mesh {

/// The box [0, size] of 8 vertices and 12 triangles, faces outward.
inline TriangleMesh BoxMesh(const Vec3& size) {
  TriangleMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    mesh.vertices.emplace_back(corner & 1 ? size.x() : 0, corner & 2 ? size.y() : 0,
                               corner & 4 ? size.z() : 0);
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

}  // namespace intaglio::mesh
