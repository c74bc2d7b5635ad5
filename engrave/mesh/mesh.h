#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::mesh {

/// Indices of a triangle's corners, counter-clockwise seen from outside.
using Triangle = std::array<std::uint32_t, 3>;

/// A triangle surface whose vertices are welded: corners with the same three
/// coordinates, bit for bit, are one vertex. Frame and unit are those of the
/// place of use: model frame and file units after import, glass frame and mm
/// after placement.
struct TriangleMesh {
  PointList vertices;
  std::vector<Triangle> triangles;

  Box3 Bounds() const {
    Box3 box;
    for (const Vec3& v : vertices) box.Extend(v);
    return box;
  }
};

}  // namespace intaglio::mesh
