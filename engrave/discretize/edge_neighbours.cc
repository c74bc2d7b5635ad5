#include "engrave/discretize/edge_neighbours.h"

#include <algorithm>
#include <numeric>
#include <span>

namespace intaglio::discretize {
namespace {

struct HalfEdge {
  std::uint32_t high;  // the edge's higher vertex
  std::uint32_t number;
  bool upward;  // from the lower vertex to the higher
};

/// The half-edges by their lower vertex, and the end of each vertex's.
struct HalfEdges {
  std::vector<HalfEdge> edges;
  std::vector<std::uint32_t> end;
};

// By counting, and then each vertex's few by the higher vertex and their number.
HalfEdges SortedHalfEdges(const mesh::TriangleMesh& mesh) {
  std::vector<std::uint32_t> at(mesh.vertices.size() + 1, 0);
  const auto for_each = [&mesh](const auto& visit) {
    std::uint32_t number = 0;
    for (const mesh::Triangle& t : mesh.triangles) {
      for (std::size_t side = 0; side < 3; ++side) {
        visit(t[side], t[(side + 1) % 3], number++);
      }
    }
  };
  for_each(
      [&](std::uint32_t a, std::uint32_t b, std::uint32_t) { ++at[std::min(a, b) + 1]; });
  std::partial_sum(at.begin(), at.end(), at.begin());
  HalfEdges sorted;
  sorted.edges.resize(3 * mesh.triangles.size());
  // Each entry of `at` moves from the beginning of its vertex's half-edges to their end.
  for_each([&](std::uint32_t a, std::uint32_t b, std::uint32_t number) {
    sorted.edges[at[std::min(a, b)]++] = {std::max(a, b), number, a < b};
  });
  std::uint32_t begin = 0;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    std::sort(sorted.edges.begin() + begin, sorted.edges.begin() + at[v],
              [](const HalfEdge& x, const HalfEdge& y) {
                return x.high != y.high ? x.high < y.high : x.number < y.number;
              });
    begin = at[v];
  }
  at.pop_back();
  sorted.end = std::move(at);
  return sorted;
}

/// Pairs the half-edges of one edge, opposite directions first.
void Pair(std::span<const HalfEdge> edge, std::vector<std::uint32_t>& neighbours) {
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    neighbours[a] = b;
    neighbours[b] = a;
  };
  if (edge.size() == 2) return join(edge[0].number, edge[1].number);
  if (edge.size() < 2) return;
  std::vector<std::uint32_t> up, down;
  for (const HalfEdge& half : edge) (half.upward ? up : down).push_back(half.number);
  const std::size_t opposite = std::min(up.size(), down.size());
  for (std::size_t i = 0; i < opposite; ++i) join(up[i], down[i]);
  const std::vector<std::uint32_t>& left = up.size() > down.size() ? up : down;
  for (std::size_t i = opposite; i + 1 < left.size(); i += 2) join(left[i], left[i + 1]);
}

}  // namespace

std::vector<std::uint32_t> EdgeNeighbours(const mesh::TriangleMesh& mesh) {
  const auto [edges, end_of_vertex] = SortedHalfEdges(mesh);
  std::vector<std::uint32_t> neighbours(edges.size(), kNoNeighbour);
  std::size_t begin = 0;
  for (const std::uint32_t end_of_low : end_of_vertex) {
    while (begin < end_of_low) {
      std::size_t end = begin + 1;
      while (end < end_of_low && edges[end].high == edges[begin].high) ++end;
      Pair(std::span(edges).subspan(begin, end - begin), neighbours);
      begin = end;
    }
  }
  return neighbours;
}

}  // namespace intaglio::discretize
