#include "engrave/mesh/vertex_normals.h"

#include <Eigen/Geometry>
#include <cmath>

namespace intaglio::mesh {

Vec3 AnglesOf(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double doubled_area = (b - a).cross(c - a).norm();
  if (!(doubled_area > 0)) return Vec3::Zero();
  // By the tangent: exact for the smallest and the largest angles, too.
  return {std::atan2(doubled_area, (b - a).dot(c - a)),
          std::atan2(doubled_area, (c - b).dot(a - b)),
          std::atan2(doubled_area, (a - c).dot(b - c))};
}

PointList VertexNormals(const TriangleMesh& mesh) {
  PointList normals(mesh.vertices.size(), Vec3::Zero());
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]],
               &c = mesh.vertices[t[2]];
    const Vec3 normal = (b - a).cross(c - a).normalized();
    const Vec3 angles = AnglesOf(a, b, c);
    if (!normal.allFinite()) continue;
    for (int i = 0; i < 3; ++i) normals[t[i]] += angles[i] * normal;
  }
  for (Vec3& normal : normals) {
    if (normal.squaredNorm() > 0) normal.normalize();
  }
  return normals;
}

Vec3 WeightsAt(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 normal = (b - a).cross(c - a);
  const Vec3 areas((c - b).cross(p - b).dot(normal), (a - c).cross(p - c).dot(normal),
                   (b - a).cross(p - a).dot(normal));
  const Vec3 positive = areas.cwiseMax(0.0);
  const double sum = positive.sum();
  if (!(sum > 0)) return Vec3::Constant(1.0 / 3);
  return positive / sum;
}

}  // namespace intaglio::mesh
