#pragma once

// Brute force and an independent spatial index, to check points against.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <vector>

#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

/// Distance of a point to a triangle: to its plane if the foot lies inside, else to the
/// nearest of its edges.
inline double DistanceToTriangle(const Vec3& p, const Vec3& a, const Vec3& b,
                                 const Vec3& c) {
  const auto to_edge = [&p](const Vec3& from, const Vec3& to) {
    const Vec3 edge = to - from;
    const double square = edge.squaredNorm();
    const double at =
        square > 0 ? std::clamp((p - from).dot(edge) / square, 0.0, 1.0) : 0.0;
    return (from + at * edge - p).norm();
  };
  const Vec3 normal = (b - a).cross(c - a);
  const bool inside = (b - a).cross(p - a).dot(normal) >= 0 &&
                      (c - b).cross(p - b).dot(normal) >= 0 &&
                      (a - c).cross(p - c).dot(normal) >= 0;
  const double length = normal.norm();
  if (inside && length > 0) return std::abs((p - a).dot(normal)) / length;
  return std::min({to_edge(a, b), to_edge(b, c), to_edge(c, a)});
}

inline double DistanceToMesh(const Vec3& p, const mesh::TriangleMesh& mesh) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& [a, b, c] : mesh.triangles) {
    smallest = std::min(smallest, DistanceToTriangle(p, mesh.vertices[a],
                                                     mesh.vertices[b], mesh.vertices[c]));
  }
  return smallest;
}

/// The largest distance of a point of the cloud to the mesh.
inline double LargestDistanceToMesh(const PointList& points,
                                    const mesh::TriangleMesh& mesh) {
  double largest = 0;
  for (const Vec3& p : points) largest = std::max(largest, DistanceToMesh(p, mesh));
  return largest;
}

/// How often the line through `origin` along `direction` crosses the mesh (Moeller and
/// Trumbore 1997). `clear` becomes false when it passes so close to an edge that rounding
/// decides.
inline int CrossingsOfLine(const mesh::TriangleMesh& mesh, const Vec3& origin,
                           const Vec3& direction, bool& clear) {
  constexpr double kHair = 1e-9;
  int count = 0;
  clear = true;
  for (const auto& [ia, ib, ic] : mesh.triangles) {
    const Vec3& a = mesh.vertices[ia];
    const Vec3 ab = mesh.vertices[ib] - a, ac = mesh.vertices[ic] - a;
    const Vec3 h = direction.cross(ac);
    const double det = ab.dot(h);
    if (std::abs(det) < 1e-14) continue;
    const Vec3 s = origin - a;
    const double u = s.dot(h) / det;
    const double v = direction.dot(s.cross(ab)) / det;
    const double inside = std::min({u, v, 1 - u - v});
    if (std::abs(inside) < kHair) clear = false;
    if (inside > 0) ++count;
  }
  return count;
}

/// Nearest points of a list, by nanoflann.
class NearestPoints {
 public:
  explicit NearestPoints(const PointList& points)
      : points_(points), tree_(3, *this, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {
    tree_.buildIndex();
  }

  /// Distance from p to the nearest, or with rank 1 to the second nearest, and so on.
  double Distance(const Vec3& p, std::size_t rank = 0) const {
    std::vector<std::size_t> index(rank + 1);
    std::vector<double> square(rank + 1);
    tree_.knnSearch(p.data(), rank + 1, index.data(), square.data());
    return std::sqrt(square[rank]);
  }
  /// To its nearest neighbour, for each point of the list.
  std::vector<double> NeighbourDistances() const {
    std::vector<double> distances;
    for (const Vec3& p : points_) distances.push_back(Distance(p, 1));
    return distances;
  }

  std::size_t kdtree_get_point_count() const { return points_.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const {
    return points_[i][static_cast<Eigen::Index>(axis)];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }

 private:
  using Tree = nanoflann::KDTreeSingleIndexAdaptor<
      nanoflann::L2_Simple_Adaptor<double, NearestPoints>, NearestPoints, 3, std::size_t>;
  const PointList& points_;
  Tree tree_;
};

inline double MinDistance(const PointList& points) {
  const std::vector<double> distances = NearestPoints(points).NeighbourDistances();
  return *std::min_element(distances.begin(), distances.end());
}

/// The largest distance of a place of the surface to the points, sampled at steps of
/// at most `step_mm` along and across every triangle, its corners included.
inline double LargestGap(const mesh::TriangleMesh& mesh, const PointList& points,
                         double step_mm) {
  const NearestPoints nearest(points);
  const auto parts = [step_mm](double length_mm) {
    return std::max(1, static_cast<int>(std::ceil(length_mm / step_mm)));
  };
  double largest = 0;
  for (mesh::Triangle t : mesh.triangles) {
    const auto edge = [&](int i) {
      return Vec3(mesh.vertices[t[(i + 1) % 3]] - mesh.vertices[t[i]]);
    };
    // Rows along the longest edge.
    while (edge(0).norm() < std::max(edge(1).norm(), edge(2).norm())) {
      std::rotate(t.begin(), t.begin() + 1, t.end());
    }
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]],
               &c = mesh.vertices[t[2]];
    if (!(edge(0).norm() > 0)) continue;
    const int rows = parts(edge(0).cross(edge(1)).norm() / edge(0).norm());
    for (int i = 0; i <= rows; ++i) {
      const double up = static_cast<double>(i) / rows;
      const Vec3 left = a + up * (c - a), right = b + up * (c - b);
      const int columns = parts((right - left).norm());
      for (int j = 0; j <= columns; ++j) {
        const Vec3 p = left + (right - left) * (static_cast<double>(j) / columns);
        largest = std::max(largest, nearest.Distance(p));
      }
    }
  }
  return largest;
}

}  // namespace intaglio::discretize
