#pragma once

// Meshes of shapes whose sections, areas and crossings are known by formula. Faces point
// outward, vertices are shared. Frame glass, mm.

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

/// Collects triangles by their corners; equal corners become one vertex.
class MeshBuilder {
 public:
  void Add(const Vec3& a, const Vec3& b, const Vec3& c) {
    mesh_.triangles.push_back({Index(a), Index(b), Index(c)});
  }
  void AddQuad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    Add(a, b, c);
    Add(a, c, d);
  }
  mesh::TriangleMesh Take() { return std::move(mesh_); }

 private:
  std::uint32_t Index(const Vec3& p) {
    const auto [at, is_new] =
        index_.try_emplace(std::tuple(p.x(), p.y(), p.z()),
                           static_cast<std::uint32_t>(mesh_.vertices.size()));
    if (is_new) mesh_.vertices.push_back(p);
    return at->second;
  }

  mesh::TriangleMesh mesh_;
  std::map<std::tuple<double, double, double>, std::uint32_t> index_;
};

/// Eight vertices, each face cut along a diagonal.
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

/// The cube [0, size]^3, each face of cells x cells squares.
inline mesh::TriangleMesh Cube(double size_mm, int cells = 1) {
  MeshBuilder builder;
  const auto at = [&](int i) { return size_mm * i / cells; };
  for (int axis = 0; axis < 3; ++axis) {
    const auto point = [&](int i, int j, double w) {
      Vec3 p;
      p[axis] = w;
      p[(axis + 1) % 3] = at(i);
      p[(axis + 2) % 3] = at(j);
      return p;
    };
    for (int i = 0; i < cells; ++i) {
      for (int j = 0; j < cells; ++j) {
        const double top = size_mm;
        builder.AddQuad(point(i, j, top), point(i + 1, j, top), point(i + 1, j + 1, top),
                        point(i, j + 1, top));
        builder.AddQuad(point(i, j, 0), point(i, j + 1, 0), point(i + 1, j + 1, 0),
                        point(i + 1, j, 0));
      }
    }
  }
  return builder.Take();
}

/// An icosahedron divided `level` times, every vertex on the sphere. Its vertex 0 is not
/// on an axis: sections and rays along the axes meet it in generic position.
inline mesh::TriangleMesh Icosphere(double radius_mm, int level, const Vec3& centre_mm) {
  const double t = std::numbers::phi;
  mesh::TriangleMesh mesh;
  mesh.vertices = {{-1, t, 0}, {1, t, 0}, {-1, -t, 0}, {1, -t, 0},
                   {0, -1, t}, {0, 1, t}, {0, -1, -t}, {0, 1, -t},
                   {t, 0, -1}, {t, 0, 1}, {-t, 0, -1}, {-t, 0, 1}};
  mesh.triangles = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                    {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                    {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                    {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (Vec3& v : mesh.vertices) v.normalize();
  for (int i = 0; i < level; ++i) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, is_new] = middles.try_emplace(
          std::minmax(a, b), static_cast<std::uint32_t>(mesh.vertices.size()));
      if (is_new) {
        const Vec3 sum = mesh.vertices[a] + mesh.vertices[b];
        mesh.vertices.push_back(sum.normalized());
      }
      return at->second;
    };
    std::vector<mesh::Triangle> divided;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      divided.insert(divided.end(),
                     {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(divided);
  }
  for (Vec3& v : mesh.vertices) v = centre_mm + radius_mm * v;
  return mesh;
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

/// A prism of `sides` sides, upright around the z axis, 0 <= z <= height, with both
/// bases.
inline mesh::TriangleMesh Cylinder(double radius_mm, double height_mm, int sides) {
  MeshBuilder builder;
  const auto point = [&](int i, double z) {
    const double u = 2 * std::numbers::pi * (i % sides) / sides;
    return Vec3(radius_mm * std::cos(u), radius_mm * std::sin(u), z);
  };
  for (int i = 0; i < sides; ++i) {
    builder.AddQuad(point(i, 0), point(i + 1, 0), point(i + 1, height_mm),
                    point(i, height_mm));
    builder.Add(Vec3(0, 0, 0), point(i + 1, 0), point(i, 0));
    builder.Add(Vec3(0, 0, height_mm), point(i, height_mm), point(i + 1, height_mm));
  }
  return builder.Take();
}

/// The part z >= 0 of a sphere around the origin, without its base: open at z = 0.
inline mesh::TriangleMesh OpenDome(double radius_mm, int sides, int rings) {
  MeshBuilder builder;
  const auto point = [&](int i, int j) {
    const double u = 2 * std::numbers::pi * (i % sides) / sides;
    const double v = 0.5 * std::numbers::pi * j / rings;
    if (j == rings) return Vec3(0, 0, radius_mm);
    return Vec3(radius_mm * std::cos(v) * std::cos(u),
                radius_mm * std::cos(v) * std::sin(u),
                j == 0 ? 0 : radius_mm * std::sin(v));
  };
  for (int i = 0; i < sides; ++i) {
    for (int j = 0; j < rings; ++j) {
      builder.Add(point(i, j), point(i + 1, j), point(i + 1, j + 1));
      if (j + 1 < rings) builder.Add(point(i, j), point(i + 1, j + 1), point(i, j + 1));
    }
  }
  return builder.Take();
}

inline mesh::TriangleMesh Turned(mesh::TriangleMesh mesh, const Mat3& turn,
                                 const Vec3& shift_mm = Vec3::Zero()) {
  for (Vec3& v : mesh.vertices) v = turn * v + shift_mm;
  return mesh;
}

}  // namespace intaglio::discretize
