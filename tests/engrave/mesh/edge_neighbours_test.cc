#include "engrave/mesh/edge_neighbours.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "tests/engrave/discretize/shapes.h"

namespace intaglio::mesh {
namespace {

using discretize::Torus;

std::pair<std::uint32_t, std::uint32_t> Edge(const mesh::TriangleMesh& mesh,
                                             std::size_t half) {
  const mesh::Triangle& t = mesh.triangles[half / 3];
  return {t[half % 3], t[(half % 3 + 1) % 3]};
}

TEST(EdgeNeighbours, OfAClosedMeshPassTheEdgeTheOtherWay) {
  const auto mesh = Torus(Vec3(0, 0, 0), 5, 2, 13, 9);
  const auto neighbours = EdgeNeighbours(mesh);
  ASSERT_EQ(neighbours.size(), 3 * mesh.triangles.size());
  for (std::size_t half = 0; half < neighbours.size(); ++half) {
    ASSERT_NE(neighbours[half], kNoNeighbour);
    const auto [a, b] = Edge(mesh, half);
    EXPECT_EQ(Edge(mesh, neighbours[half]), std::pair(b, a));
    EXPECT_EQ(neighbours[neighbours[half]], half);
  }
}

// Triangles of few corners: edges of one, two and many triangles, repeated corners.
TEST(EdgeNeighbours, OfAHeapOfTrianglesAreMutualAndAsManyAsCanBe) {
  std::mt19937 random(2);
  for (int round = 0; round < 200; ++round) {
    mesh::TriangleMesh mesh;
    mesh.vertices.assign(6 + round % 20, Vec3::Zero());
    const auto corner = [&] {
      return static_cast<std::uint32_t>(random() % mesh.vertices.size());
    };
    for (int i = 0; i < 60; ++i) mesh.triangles.push_back({corner(), corner(), corner()});
    const auto neighbours = EdgeNeighbours(mesh);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::array<int, 3>> edges;
    for (std::size_t half = 0; half < neighbours.size(); ++half) {
      const mesh::Triangle& t = mesh.triangles[half / 3];
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
        EXPECT_EQ(neighbours[half], kNoNeighbour);
        continue;
      }
      const auto [a, b] = Edge(mesh, half);
      auto& [up, down, opposite] = edges[std::minmax(a, b)];
      ++(a < b ? up : down);
      if (neighbours[half] == kNoNeighbour) continue;
      EXPECT_EQ(neighbours[neighbours[half]], half);
      EXPECT_NE(neighbours[half] / 3, half / 3);
      const auto other = Edge(mesh, neighbours[half]);
      EXPECT_EQ(std::minmax(other.first, other.second), std::minmax(a, b));
      opposite += other == std::pair(b, a) ? 1 : 0;
    }
    std::size_t open = 0, expected_open = 0;
    for (const auto& [edge, counts] : edges) {
      const auto& [up, down, opposite] = counts;
      EXPECT_EQ(opposite, 2 * std::min(up, down));
      expected_open += static_cast<std::size_t>(up + down) % 2;
    }
    for (std::size_t half = 0; half < neighbours.size(); ++half) {
      const mesh::Triangle& t = mesh.triangles[half / 3];
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
      open += neighbours[half] == kNoNeighbour ? 1 : 0;
    }
    EXPECT_EQ(open, expected_open);
  }
}

}  // namespace
}  // namespace intaglio::mesh
