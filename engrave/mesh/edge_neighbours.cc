#include "engrave/mesh/edge_neighbours.h"

#include <algorithm>
#include <span>

#include "engrave/mesh/half_edges.h"

namespace intaglio::mesh {
namespace {

/// Pairs the half-edges of an edge of more than two, opposite directions first.
void PairMany(std::span<const HalfEdge> edge, std::vector<std::uint32_t>& neighbours) {
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    neighbours[a] = b;
    neighbours[b] = a;
  };
  std::vector<std::uint32_t> up, down;
  for (const HalfEdge half : edge) {
    (half.upward() ? up : down).push_back(half.number());
  }
  const std::size_t opposite = std::min(up.size(), down.size());
  for (std::size_t i = 0; i < opposite; ++i) join(up[i], down[i]);
  const std::vector<std::uint32_t>& left = up.size() > down.size() ? up : down;
  for (std::size_t i = opposite; i + 1 < left.size(); i += 2) join(left[i], left[i + 1]);
}

}  // namespace

std::vector<std::uint32_t> EdgeNeighbours(const TriangleMesh& mesh) {
  HalfEdges half_edges(mesh);
  std::vector<std::uint32_t> neighbours(3 * mesh.triangles.size(), kNoNeighbour);
  half_edges.ForEachEdge([&](std::uint32_t, std::span<const HalfEdge> edge) {
    if (edge.size() == 2) {
      const std::uint32_t a = edge[0].number(), b = edge[1].number();
      neighbours[a] = b;
      neighbours[b] = a;
    } else if (edge.size() > 2) {
      PairMany(edge, neighbours);
    }
  });
  return neighbours;
}

}  // namespace intaglio::mesh
