#include "engrave/discretize/edge_neighbours.h"

#include <algorithm>

namespace intaglio::discretize {
namespace {

struct HalfEdge {
  std::uint64_t key;  // the two vertices, lower first
  std::uint32_t number;
  bool upward;  // from the lower vertex to the higher
};

std::vector<HalfEdge> SortedHalfEdges(const mesh::TriangleMesh& mesh) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::uint32_t side = 0; side < 3; ++side) {
      const std::uint32_t a = mesh.triangles[t][side];
      const std::uint32_t b = mesh.triangles[t][(side + 1) % 3];
      edges.push_back({static_cast<std::uint64_t>(std::min(a, b)) << 32 | std::max(a, b),
                       3 * t + side, a < b});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& x, const HalfEdge& y) {
    return x.key != y.key ? x.key < y.key : x.number < y.number;
  });
  return edges;
}

}  // namespace

std::vector<std::uint32_t> EdgeNeighbours(const mesh::TriangleMesh& mesh) {
  const std::vector<HalfEdge> edges = SortedHalfEdges(mesh);
  std::vector<std::uint32_t> neighbours(edges.size(), kNoNeighbour);
  std::vector<std::uint32_t> left;
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    neighbours[a] = b;
    neighbours[b] = a;
  };
  for (std::size_t begin = 0; begin < edges.size();) {
    std::size_t end = begin;
    while (end < edges.size() && edges[end].key == edges[begin].key) ++end;
    std::vector<std::uint32_t> up, down;
    if (end - begin == 2) {
      join(edges[begin].number, edges[begin + 1].number);
    } else if (end - begin > 2) {
      for (std::size_t i = begin; i < end; ++i) {
        (edges[i].upward ? up : down).push_back(edges[i].number);
      }
      const std::size_t opposite = std::min(up.size(), down.size());
      for (std::size_t i = 0; i < opposite; ++i) join(up[i], down[i]);
      left.assign(up.begin() + static_cast<std::ptrdiff_t>(opposite), up.end());
      left.insert(left.end(), down.begin() + static_cast<std::ptrdiff_t>(opposite),
                  down.end());
      for (std::size_t i = 0; i + 1 < left.size(); i += 2) join(left[i], left[i + 1]);
    }
    begin = end;
  }
  return neighbours;
}

}  // namespace intaglio::discretize
