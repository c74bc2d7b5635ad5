#include "engrave/discretize/mesh/ray_caster.h"

#include <cmath>

namespace intaglio::discretize {

RayCaster::RayCaster(const RayGrid& grid, const PointList& vertices) : grid_(grid) {
  corners_.reserve(vertices.size());
  for (const Vec3& v : vertices) {
    RayCorner corner = {grid.Rounded(v.x()), grid.Rounded(v.y()), v.z(), 0, 0};
    corner.column = grid.ColumnFrom(corner.u);
    corner.row = grid.RowFrom(corner.v);
    corners_.push_back(corner);
  }
}

double RayCaster::CrossingsAbout(std::span<const mesh::Triangle> triangles) const {
  double twice_mm2 = 0;
  for (const mesh::Triangle& t : triangles) {
    const RayCorner &a = corners_[t[0]], &b = corners_[t[1]], &c = corners_[t[2]];
    twice_mm2 += std::abs((b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u));
  }
  return 0.5 * twice_mm2 / (grid_.step_u_mm * grid_.step_v_mm);
}

}  // namespace intaglio::discretize
