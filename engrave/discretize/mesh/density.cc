#include "engrave/discretize/mesh/density.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/mesh/vertex_normals.h"

namespace intaglio::discretize {
namespace {

/// A value of each vertex, linear over the triangles.
Density Interpolated(const mesh::TriangleMesh& mesh, std::vector<float> values) {
  struct Field {
    mesh::TriangleMesh mesh;
    std::vector<float> values;
  };
  const auto field = std::make_shared<const Field>(Field{mesh, std::move(values)});
  return [field](const SurfacePoint& point) {
    const mesh::Triangle& t = field->mesh.triangles[point.triangle];
    const PointList& v = field->mesh.vertices;
    const Vec3 weights = mesh::WeightsAt(point.p_mm, v[t[0]], v[t[1]], v[t[2]]);
    return weights.x() * field->values[t[0]] + weights.y() * field->values[t[1]] +
           weights.z() * field->values[t[2]];
  };
}

}  // namespace

Density DensityByPlace(std::function<double(const Vec3&)> value_at) {
  return [value_at = std::move(value_at)](const SurfacePoint& point) {
    return value_at(point.p_mm);
  };
}

// Along an edge the normal turns by |n_b - n_a| / |b - a|, about the normal curvature in
// that direction. The root of the mean square over a vertex's edges is right for ridges,
// which bend in one direction only, and for tips; triangles' edges count once for each
// side.
Density DensityByCurvature(const mesh::TriangleMesh& mesh, double turn_rad_per_mm) {
  Require(turn_rad_per_mm > 0, "turn_rad_per_mm must be positive, is {}",
          turn_rad_per_mm);
  const PointList normals = mesh::VertexNormals(mesh);
  std::vector<double> square(mesh.vertices.size(), 0), count(mesh.vertices.size(), 0);
  for (const mesh::Triangle& t : mesh.triangles) {
    for (int side = 0; side < 3; ++side) {
      const std::uint32_t a = t[side], b = t[(side + 1) % 3];
      const double length = (mesh.vertices[b] - mesh.vertices[a]).squaredNorm();
      if (!(length > 0)) continue;
      const double turn = (normals[b] - normals[a]).squaredNorm() / length;
      for (const std::uint32_t vertex : {a, b}) {
        square[vertex] += turn;
        count[vertex] += 1;
      }
    }
  }
  std::vector<float> values(mesh.vertices.size(), 0);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (count[i] == 0) continue;
    const double turn = std::sqrt(square[i] / count[i]);
    values[i] = static_cast<float>(std::min(1.0, turn / turn_rad_per_mm));
  }
  return Interpolated(mesh, std::move(values));
}

Density DensityByLight(const mesh::TriangleMesh& mesh, const Vec3& light_from) {
  Require(light_from.norm() > 0, "light_from has no direction");
  const Vec3 light = light_from.normalized();
  std::vector<float> values;
  values.reserve(mesh.vertices.size());
  for (const Vec3& normal : mesh::VertexNormals(mesh)) {
    values.push_back(static_cast<float>(std::max(0.0, normal.dot(light))));
  }
  return Interpolated(mesh, std::move(values));
}

double SpacingFor(double density, double dense_mm, double sparse_mm) {
  const double share = std::clamp(density, 0.0, 1.0);
  const double dense = 1 / (dense_mm * dense_mm), sparse = 1 / (sparse_mm * sparse_mm);
  return 1 / std::sqrt(sparse + share * (dense - sparse));
}

}  // namespace intaglio::discretize
