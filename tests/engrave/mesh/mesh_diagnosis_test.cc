#include "engrave/mesh/mesh_diagnosis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <utility>

#include "engrave/mesh/weld_vertices.h"
#include "tests/engrave/mesh/test_meshes.h"

namespace intaglio::mesh {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A warning with this in its sentence.
auto TextHas(const char* text) {
  return ::testing::Field(&Warning::text, HasSubstr(text));
}

TEST(MeshDiagnosis, FindsNothingWrongWithABox) {
  const MeshDiagnosis d = Diagnose(BoxMesh({2, 3, 4}));
  EXPECT_EQ(d.triangle_count, 12u);
  EXPECT_EQ(d.vertex_count, 8u);
  EXPECT_EQ(d.edge_count, 18u);
  EXPECT_EQ(d.component_count, 1u);
  EXPECT_EQ(d.euler_characteristic, 2);
  EXPECT_TRUE(d.closed());
  EXPECT_TRUE(d.orientable);
  EXPECT_EQ(d.bounds_mm.max_mm, Vec3(2, 3, 4));
  // Sums of small integers and halves: exact.
  EXPECT_EQ(d.signed_volume_mm3, 24);
  EXPECT_EQ(d.area_mm2, 52);
  EXPECT_THAT(WarningsOf(d, "box.stl"), IsEmpty());
}

TEST(MeshDiagnosis, CountsAHoleAndWarns) {
  TriangleMesh mesh = BoxMesh({1, 1, 1});
  mesh.triangles.pop_back();
  const MeshDiagnosis d = Diagnose(mesh);
  EXPECT_EQ(d.open_edge_count, 3u);
  EXPECT_FALSE(d.closed());
  EXPECT_EQ(d.euler_characteristic, 1);
  EXPECT_THAT(WarningsOf(d, "box.stl"),
              ElementsAre(TextHas("box.stl: the surface is open along 3 edges")));
}

TEST(MeshDiagnosis, CountsTheTrianglesToTurnOver) {
  TriangleMesh mesh = BoxMesh({1, 1, 1});
  for (const std::size_t t : {0u, 5u, 6u}) {
    std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
  }
  const MeshDiagnosis d = Diagnose(mesh);
  EXPECT_EQ(d.flipped_triangle_count, 3u);
  // Triangles 0, 5 and 6 do not touch along an edge: each spoils its three.
  EXPECT_EQ(d.flipped_edge_count, 9u);
  EXPECT_TRUE(d.closed());
  EXPECT_TRUE(d.orientable);
  EXPECT_THAT(WarningsOf(d, "m"),
              ElementsAre(TextHas("3 triangles are oriented against")));
}

TEST(MeshDiagnosis, ReportsWhenTheWholeSurfaceIsInsideOut) {
  TriangleMesh mesh = BoxMesh({1, 1, 1});
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  const MeshDiagnosis d = Diagnose(mesh);
  EXPECT_EQ(d.flipped_triangle_count, 0u);
  EXPECT_EQ(d.signed_volume_mm3, -1);
  EXPECT_THAT(WarningsOf(d, "m"), ElementsAre(TextHas("inside out")));
}

TEST(MeshDiagnosis, AnInsideOutSurfaceWithASmallHoleIsReportedAsWell) {
  // 6 sides of 20 x 20 squares; a missing triangle opens 3 of 3600 edges.
  TriangleMesh mesh;
  constexpr int kCells = 20;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {0.0, 1.0}) {
      const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
      for (int i = 0; i <= kCells; ++i) {
        for (int j = 0; j <= kCells; ++j) {
          Vec3 p;
          p[axis] = side;
          p[(axis + 1) % 3] = static_cast<double>(i) / kCells;
          p[(axis + 2) % 3] = static_cast<double>(j) / kCells;
          mesh.vertices.push_back(p);
        }
      }
      for (std::uint32_t i = 0; i < kCells; ++i) {
        for (std::uint32_t j = 0; j < kCells; ++j) {
          const std::uint32_t a = first + i * (kCells + 1) + j, b = a + kCells + 1;
          std::array<Triangle, 2> two = {Triangle{a, b, b + 1},
                                         Triangle{a, b + 1, a + 1}};
          for (Triangle& t : two) {
            if (side == 1) std::swap(t[0], t[1]);  // all sides face inward
            mesh.triangles.push_back(t);
          }
        }
      }
    }
  }
  VertexWelder welder;
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& corner : t) corner = welder.Add(mesh.vertices[corner]);
  }
  mesh.vertices = welder.TakePoints();
  mesh.triangles.pop_back();
  const MeshDiagnosis d = Diagnose(mesh);
  EXPECT_FALSE(d.closed());
  EXPECT_EQ(d.open_edge_count, 3u);
  EXPECT_TRUE(d.inside_out());
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_FALSE(Diagnose(mesh).inside_out());
  // Two sides of a box enclose nothing for certain.
  mesh.triangles.resize(mesh.triangles.size() / 3);
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_FALSE(Diagnose(mesh).inside_out());
}

TEST(MeshDiagnosis, CountsPartsThatShareAVertexButNoEdge) {
  TriangleMesh mesh = BoxMesh({1, 1, 1});
  const TriangleMesh other = BoxMesh({-1, -1, -1});  // mirrored in the origin, inside out
  for (std::size_t v = 1; v < 8; ++v) mesh.vertices.push_back(other.vertices[v]);
  for (Triangle t : other.triangles) {
    for (std::uint32_t& corner : t) corner = corner == 0 ? 0 : corner + 7;
    mesh.triangles.push_back({t[1], t[0], t[2]});
  }
  const MeshDiagnosis d = Diagnose(mesh);
  EXPECT_EQ(d.component_count, 2u);
  EXPECT_EQ(d.vertex_count, 15u);
  EXPECT_EQ(d.non_manifold_edge_count, 0u);
  EXPECT_TRUE(d.closed());
  EXPECT_EQ(d.signed_volume_mm3, 2);
}

TEST(MeshDiagnosis, DistinguishesDegenerateFromDuplicate) {
  TriangleMesh mesh = BoxMesh({1, 1, 1});
  mesh.vertices.emplace_back(0.5, 0, 0);  // on the edge between vertices 0 and 1
  mesh.triangles.push_back({0, 0, 1});    // a repeated corner: no part in the edges
  mesh.triangles.push_back({0, 8, 1});    // no area
  mesh.triangles.push_back({3, 0, 2});    // triangle 0 again, begun elsewhere
  const MeshDiagnosis d = Diagnose(mesh);
  EXPECT_EQ(d.degenerate_triangle_count, 2u);
  EXPECT_EQ(d.duplicate_triangle_count, 1u);
  // The doubled triangle's three edges, and 0-1 with the triangle that has no area.
  EXPECT_EQ(d.non_manifold_edge_count, 4u);
  EXPECT_EQ(d.open_edge_count, 2u) << "0-8 and 8-1";
  EXPECT_EQ(d.component_count, 1u);
}

TEST(MeshDiagnosis, FindsAMoebiusStrip) {
  // Five triangles in a ring with a half turn: {i, i+1, i+2} modulo 5.
  TriangleMesh mesh;
  for (int i = 0; i < 5; ++i) mesh.vertices.emplace_back(i * i, i, i % 2);
  for (std::uint32_t i = 0; i < 5; ++i) {
    mesh.triangles.push_back({i, (i + 1) % 5, (i + 2) % 5});
  }
  const MeshDiagnosis d = Diagnose(mesh);
  EXPECT_FALSE(d.orientable);
  EXPECT_EQ(d.euler_characteristic, 0);
  EXPECT_EQ(d.open_edge_count, 5u);
  EXPECT_THAT(WarningsOf(d, "m"), Contains(TextHas("Moebius")));
}

TEST(MeshDiagnosis, IgnoresVerticesNoTriangleUses) {
  TriangleMesh mesh = BoxMesh({1, 1, 1});
  mesh.vertices.emplace_back(1000, 0, 0);
  const MeshDiagnosis d = Diagnose(mesh);
  EXPECT_EQ(d.vertex_count, 8u);
  EXPECT_EQ(d.bounds_mm.max_mm, Vec3(1, 1, 1));
}

TEST(MeshDiagnosis, OfAnEmptyMeshIsNotClosed) {
  const MeshDiagnosis d = Diagnose({});
  EXPECT_EQ(d.triangle_count, 0u);
  EXPECT_FALSE(d.closed());
}

/// Edge counts by a map of edges, one triangle after another.
struct EdgeOracle {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<bool>> uses;

  explicit EdgeOracle(const TriangleMesh& mesh) {
    for (const Triangle& t : mesh.triangles) {
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
      for (int c = 0; c < 3; ++c) {
        const auto [low, high] = std::minmax(t[c], t[(c + 1) % 3]);
        uses[{low, high}].push_back(t[c] == low);
      }
    }
  }
  template <typename Kind>
  std::uint64_t Count(Kind is_kind) const {
    return std::count_if(uses.begin(), uses.end(),
                         [&](const auto& edge) { return is_kind(edge.second); });
  }
};

std::uint64_t DuplicatesByASet(const TriangleMesh& mesh) {
  std::set<Triangle> distinct;
  for (Triangle t : mesh.triangles) {
    std::sort(t.begin(), t.end());
    distinct.insert(t);
  }
  return mesh.triangles.size() - distinct.size();
}

/// Triangles with two corners in common are of one part, until nothing changes.
std::uint64_t PartsByRelabelling(const TriangleMesh& mesh) {
  std::vector<Triangle> edged;
  for (Triangle t : mesh.triangles) {
    std::sort(t.begin(), t.end());
    if (t[0] != t[1] && t[1] != t[2]) edged.push_back(t);
  }
  std::vector<std::size_t> part(edged.size());
  std::iota(part.begin(), part.end(), std::size_t{0});
  for (bool changed = true; changed;) {
    changed = false;
    for (std::size_t a = 0; a < edged.size(); ++a) {
      for (std::size_t b = 0; b < edged.size(); ++b) {
        Triangle common;
        const auto end =
            std::set_intersection(edged[a].begin(), edged[a].end(), edged[b].begin(),
                                  edged[b].end(), common.begin());
        if (end - common.begin() < 2 || part[a] <= part[b]) continue;
        part[a] = part[b];
        changed = true;
      }
    }
  }
  return std::set<std::size_t>(part.begin(), part.end()).size();
}

TEST(MeshDiagnosis, AgreesWithAMapOfEdgesOnTriangleSoup) {
  std::mt19937 random(7);
  for (int round = 0; round < 200; ++round) {
    TriangleMesh mesh;
    const std::uint32_t vertex_count = 4 + random() % 20;
    for (std::uint32_t v = 0; v < vertex_count; ++v) {
      mesh.vertices.emplace_back(random() % 100, random() % 100, random() % 100);
    }
    for (std::uint32_t t = 0; t < 1 + random() % 40; ++t) {
      Triangle corners;
      for (auto& corner : corners) {
        corner = static_cast<std::uint32_t>(random() % vertex_count);
      }
      mesh.triangles.push_back(corners);
    }
    const MeshDiagnosis d = Diagnose(mesh);
    const EdgeOracle oracle(mesh);
    EXPECT_EQ(d.edge_count, oracle.uses.size());
    EXPECT_EQ(d.open_edge_count,
              oracle.Count([](const auto& u) { return u.size() == 1; }));
    EXPECT_EQ(d.non_manifold_edge_count,
              oracle.Count([](const auto& u) { return u.size() > 2; }));
    EXPECT_EQ(d.flipped_edge_count,
              oracle.Count([](const auto& u) { return u.size() == 2 && u[0] == u[1]; }));
    EXPECT_EQ(d.duplicate_triangle_count, DuplicatesByASet(mesh));
    EXPECT_EQ(d.component_count, PartsByRelabelling(mesh));
  }
}

}  // namespace
}  // namespace intaglio::mesh
