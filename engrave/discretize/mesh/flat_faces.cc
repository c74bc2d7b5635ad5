#include "engrave/discretize/mesh/flat_faces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "engrave/core/try.h"
#include "engrave/discretize/mesh/ray_caster.h"
#include "engrave/discretize/spacing/statistics.h"
#include "engrave/mesh/edge_neighbours.h"

namespace intaglio::discretize {
namespace {

constexpr double kParallelCosine = 0.9999985;  // of 0.1 degrees

/// Sets of these triangles that hang together by edges.
std::uint64_t CountFaces(const std::vector<std::uint32_t>& flat,
                         const std::vector<std::uint32_t>& neighbours) {
  std::vector<bool> waiting(neighbours.size() / 3, false);
  for (const std::uint32_t t : flat) waiting[t] = true;
  std::uint64_t count = 0;
  std::vector<std::uint32_t> open;
  for (const std::uint32_t seed : flat) {
    if (!waiting[seed]) continue;
    ++count;
    waiting[seed] = false;
    open.assign(1, seed);
    while (!open.empty()) {
      const std::uint32_t t = open.back();
      open.pop_back();
      for (std::uint32_t side = 0; side < 3; ++side) {
        const std::uint32_t across = neighbours[3 * t + side];
        if (across == mesh::kNoNeighbour || !waiting[across / 3]) continue;
        waiting[across / 3] = false;
        open.push_back(across / 3);
      }
    }
  }
  return count;
}

}  // namespace

FlatFaces FindFlatFaces(const mesh::TriangleMesh& mesh,
                        const std::vector<std::uint32_t>& neighbours,
                        const Vec3& normal) {
  FlatFaces faces;
  std::vector<std::uint32_t> flat;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vec3& p = mesh.vertices[a];
    const Vec3 cross = (mesh.vertices[b] - p).cross(mesh.vertices[c] - p);
    const double square = cross.squaredNorm(), along = cross.dot(normal);
    const double flat_square = along * along;
    if (square > 0 && flat_square >= kParallelCosine * kParallelCosine * square) {
      flat.push_back(t);
      faces.triangles.push_back(mesh.triangles[t]);
      faces.area_mm2 += std::sqrt(square) / 2;
    } else {
      faces.wall_area_mm2 += std::sqrt(std::max(0.0, square - flat_square)) / 2;
    }
  }
  if (!flat.empty()) faces.face_count = CountFaces(flat, neighbours);
  return faces;
}

// The grid of equilateral triangles is two of rectangles, one between the other.
Result<PointList> CoverFlatFaces(const FlatFaces& faces, const PointList& vertices,
                                 const Mat3& frame, double distance_mm) {
  Box3 box;
  PointList turned;
  turned.reserve(vertices.size());
  for (const Vec3& p : vertices) turned.emplace_back(frame.transpose() * p);
  for (const mesh::Triangle& t : faces.triangles) {
    for (const std::uint32_t corner : t) box.Extend(turned[corner]);
  }
  PointList points;
  if (box.empty()) return points;
  const double step_mm = distance_mm * kRoundingAllowance;
  const RayGrid grid =
      INTAGLIO_TRY(GridOver(box, step_mm, std::numbers::sqrt3 * step_mm));
  for (const RayGrid& part : {grid, grid.Between()}) {
    const Status cast =
        RayCaster(part, turned)
            .Cast(faces.triangles, [&](std::uint32_t column, std::uint32_t row,
                                       std::span<const double> ray) {
              for (const double w_mm : ray) {
                points.emplace_back(frame * Vec3(part.U(column), part.V(row), w_mm));
              }
            });
    if (!cast) return tl::unexpected(cast.error());
  }
  return points;
}

}  // namespace intaglio::discretize
