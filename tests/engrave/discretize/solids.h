#pragma once

// Meshes whose surface is known, for tests. All closed, faces outward.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/mesh/mesh.h"

namespace intaglio::discretize::testing {

inline mesh::TriangleMesh Cuboid(const Vec3& low, const Vec3& high) {
  mesh::TriangleMesh m;
  for (int i = 0; i < 8; ++i) {
    m.vertices.emplace_back((i & 1) != 0 ? high.x() : low.x(),
                            (i & 2) != 0 ? high.y() : low.y(),
                            (i & 4) != 0 ? high.z() : low.z());
  }
  m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return m;
}

/// A torus about z: R from the axis to the tube's centre, r of the tube.
inline mesh::TriangleMesh Torus(const Vec3& centre, double R, double r, unsigned n,
                                unsigned m) {
  mesh::TriangleMesh mesh;
  const auto turn = [](unsigned i, unsigned of) { return 2 * std::numbers::pi * i / of; };
  for (unsigned i = 0; i < n; ++i) {
    for (unsigned j = 0; j < m; ++j) {
      const double rho = R + r * std::cos(turn(j, m));
      mesh.vertices.push_back(centre + Vec3(rho * std::cos(turn(i, n)),
                                            rho * std::sin(turn(i, n)),
                                            r * std::sin(turn(j, m))));
    }
  }
  for (unsigned i = 0; i < n; ++i) {
    for (unsigned j = 0; j < m; ++j) {
      const unsigned a = i * m + j, b = (i + 1) % n * m + j,
                     c = (i + 1) % n * m + (j + 1) % m, d = i * m + (j + 1) % m;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

/// Latitude and longitude; poles are single vertices.
inline mesh::TriangleMesh Sphere(const Vec3& centre, double r, unsigned n, unsigned m) {
  mesh::TriangleMesh mesh;
  mesh.vertices.push_back(centre - Vec3(0, 0, r));
  for (unsigned i = 1; i < n; ++i) {
    const double polar = -std::numbers::pi / 2 + std::numbers::pi * i / n;
    for (unsigned j = 0; j < m; ++j) {
      const double turn = 2 * std::numbers::pi * j / m;
      mesh.vertices.push_back(centre + r * Vec3(std::cos(polar) * std::cos(turn),
                                                std::cos(polar) * std::sin(turn),
                                                std::sin(polar)));
    }
  }
  const unsigned top = static_cast<unsigned>(mesh.vertices.size());
  mesh.vertices.push_back(centre + Vec3(0, 0, r));
  const auto at = [m](unsigned i, unsigned j) { return 1 + (i - 1) * m + j % m; };
  for (unsigned j = 0; j < m; ++j) {
    mesh.triangles.push_back({0, at(1, j + 1), at(1, j)});
    mesh.triangles.push_back({top, at(n - 1, j), at(n - 1, j + 1)});
    for (unsigned i = 1; i + 1 < n; ++i) {
      mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
    }
  }
  return mesh;
}

/// Distance of a point from the surface; brute force over all triangles.
inline double DistanceToSurface(const mesh::TriangleMesh& mesh, const Vec3& p) {
  double least = INFINITY;
  for (const mesh::Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]],
               &c = mesh.vertices[t[2]];
    const auto to_edge = [&p](const Vec3& q, const Vec3& r) {
      const double s = std::clamp((p - q).dot(r - q) / (r - q).squaredNorm(), 0.0, 1.0);
      return (p - q - s * (r - q)).norm();
    };
    least = std::min({least, to_edge(a, b), to_edge(b, c), to_edge(c, a)});
    const Vec3 normal = (b - a).cross(c - a);
    const bool within = (b - a).cross(p - a).dot(normal) >= 0 &&
                        (c - b).cross(p - b).dot(normal) >= 0 &&
                        (a - c).cross(p - c).dot(normal) >= 0;
    if (within && normal.norm() > 0) {
      least = std::min(least, std::abs((p - a).dot(normal)) / normal.norm());
    }
  }
  return least;
}

}  // namespace intaglio::discretize::testing
