#pragma once

// Meshes like those that people bring: figures with bumps, scans with holes, knots,
// machined parts. All of them are computed, so their topology is known. Frame glass, mm.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/engrave/discretize/shapes.h"

namespace intaglio::discretize {

/// A closed figure of 20 * 4^level triangles, genus 0, about 14 mm: an icosphere whose
/// radius swells into a head and two ears, with folds of 0.2 mm on the whole surface.
inline mesh::TriangleMesh Figurine(int level) {
  mesh::TriangleMesh mesh = Icosphere(1, level, Vec3::Zero());
  const auto bump = [](const Vec3& at, const Vec3& towards, double sharpness) {
    return std::exp(sharpness * (at.dot(towards.normalized()) - 1));
  };
  for (Vec3& v : mesh.vertices) {
    const double radius_mm = 4 + 2.5 * bump(v, {0.8, 0.1, 1}, 8) +
                             3 * bump(v, {0.5, 0.4, 1}, 60) +
                             3 * bump(v, {0.5, -0.4, 1}, 60) +
                             0.2 * std::sin(9 * v.x()) * std::cos(11 * v.y() + 7 * v.z());
    v *= radius_mm;
  }
  return mesh;
}

/// Without its first `count` vertices and the triangles around them: each leaves a hole.
/// The first 12 of an icosphere of level 2 or more have no triangle or border in common.
inline mesh::TriangleMesh WithHoles(mesh::TriangleMesh mesh, std::uint32_t count) {
  std::erase_if(mesh.triangles, [&](const mesh::Triangle& t) {
    return *std::min_element(t.begin(), t.end()) < count;
  });
  mesh.vertices.erase(mesh.vertices.begin(), mesh.vertices.begin() + count);
  for (mesh::Triangle& t : mesh.triangles) {
    for (auto& corner : t) corner -= count;
  }
  return mesh;
}

/// A tube of radius r around a trefoil knot of 6 mm, n rings of m corners: closed, of
/// genus 1. Trefoil: (sin t + 2 sin 2t, cos t - 2 cos 2t, -sin 3t).
inline mesh::TriangleMesh Trefoil(double r, unsigned n, unsigned m) {
  mesh::TriangleMesh mesh;
  for (unsigned i = 0; i < n; ++i) {
    const double t = 2 * std::numbers::pi * i / n;
    const Vec3 centre(std::sin(t) + 2 * std::sin(2 * t),
                      std::cos(t) - 2 * std::cos(2 * t), -std::sin(3 * t));
    const Vec3 along = Vec3(std::cos(t) + 4 * std::cos(2 * t),
                            -std::sin(t) + 4 * std::sin(2 * t), -3 * std::cos(3 * t))
                           .normalized();
    const Vec3 level = Vec3::UnitZ().cross(along).normalized();  // nowhere upright
    const Vec3 across = along.cross(level);
    for (unsigned j = 0; j < m; ++j) {
      const double u = 2 * std::numbers::pi * j / m;
      mesh.vertices.push_back(centre + r * (std::cos(u) * level + std::sin(u) * across));
    }
  }
  for (unsigned i = 0; i < n; ++i) {
    for (unsigned j = 0; j < m; ++j) {
      const unsigned a = i * m + j, b = (i + 1) % n * m + j,
                     c = (i + 1) % n * m + (j + 1) % m, d = i * m + (j + 1) % m;
      mesh.triangles.push_back({a, c, b});
      mesh.triangles.push_back({a, d, c});
    }
  }
  return mesh;
}

/// A torus whose hole has shrunk to the origin: closed, and one vertex is pinched. Its
/// Euler characteristic is 1. n sectors, m triangles from the origin to the origin.
inline mesh::TriangleMesh PinchedTorus(double r, int n, int m) {
  MeshBuilder builder;
  const auto point = [&](int i, int j) {
    if (j == 0 || j == m) return Vec3(0, 0, 0);
    const double turn = 2 * std::numbers::pi * (i % n) / n;
    const double tube = std::numbers::pi * (2.0 * j / m - 1);
    const double rho = r * (1 + std::cos(tube));
    return Vec3(rho * std::cos(turn), rho * std::sin(turn), r * std::sin(tube));
  };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < m; ++j) {
      if (j > 0) builder.Add(point(i, j), point(i + 1, j), point(i + 1, j + 1));
      if (j + 1 < m) builder.Add(point(i, j), point(i + 1, j + 1), point(i, j + 1));
    }
  }
  return builder.Take();
}

/// A plate of cubes of edge e with `holes` square holes through it in a row: sharp
/// edges, closed, Euler characteristic 2 - 2 holes.
inline mesh::TriangleMesh PiercedPlate(double e, int holes) {
  const auto solid = [&](int x, int y, int z) {
    if (x < 0 || y < 0 || z < 0 || x > 2 * holes || y > 2 || z > 0) return false;
    return y != 1 || x % 2 == 0;
  };
  MeshBuilder builder;
  const auto add_face = [&](const Vec3& cell, int axis, int side) {
    Vec3 corner = cell, u = Vec3::Zero(), v = Vec3::Zero();
    corner[axis] += side;
    u[(axis + (side != 0 ? 1 : 2)) % 3] = 1;
    v[(axis + (side != 0 ? 2 : 1)) % 3] = 1;
    builder.AddQuad(e * corner, e * (corner + u), e * (corner + u + v), e * (corner + v));
  };
  for (int x = 0; x <= 2 * holes; ++x) {
    for (int y = 0; y <= 2; ++y) {
      if (!solid(x, y, 0)) continue;
      for (int axis = 0; axis < 3; ++axis) {
        for (const int side : {0, 1}) {
          const int step = 2 * side - 1;
          if (!solid(x + (axis == 0 ? step : 0), y + (axis == 1 ? step : 0),
                     axis == 2 ? step : 0)) {
            add_face(Vec3(x, y, 0), axis, side);
          }
        }
      }
    }
  }
  return builder.Take();
}

/// The mesh `count` times, each beside the one before.
inline mesh::TriangleMesh InARow(const mesh::TriangleMesh& mesh, int count) {
  mesh::TriangleMesh row;
  const double step_mm = 1.5 * mesh.Bounds().size_mm().x();
  for (int i = 0; i < count; ++i) {
    const auto first = static_cast<std::uint32_t>(row.vertices.size());
    for (const Vec3& v : mesh.vertices)
      row.vertices.push_back(v + Vec3(i * step_mm, 0, 0));
    for (const auto& [a, b, c] : mesh.triangles) {
      row.triangles.push_back({first + a, first + b, first + c});
    }
  }
  return row;
}

}  // namespace intaglio::discretize
