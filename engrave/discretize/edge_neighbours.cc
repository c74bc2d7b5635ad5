#include "engrave/discretize/edge_neighbours.h"

#include <algorithm>
#include <numeric>
#include <span>

#include "engrave/core/check.h"

namespace intaglio::discretize {
namespace {

// A half-edge as one number, by its place among those of its edge's lower vertex: the
// edge's higher vertex, its own number, and whether it runs from the lower to the higher.
using HalfEdge = std::uint64_t;

HalfEdge Packed(std::uint32_t high, std::uint32_t number, bool upward) {
  return std::uint64_t{high} << 32 | std::uint64_t{number} << 1 | (upward ? 1 : 0);
}
std::uint32_t HighOf(HalfEdge half) { return static_cast<std::uint32_t>(half >> 32); }
std::uint32_t NumberOf(HalfEdge half) { return static_cast<std::uint32_t>(half) >> 1; }
bool IsUpward(HalfEdge half) { return (half & 1) != 0; }

/// The half-edges by their lower vertex, and the end of each vertex's.
struct HalfEdges {
  std::vector<HalfEdge> edges;
  std::vector<std::uint32_t> end;
};

/// Mostly six or so.
void SortFew(HalfEdge* begin, HalfEdge* end) {
  if (end - begin > 24) return std::sort(begin, end);
  for (HalfEdge* at = begin + 1; at < end; ++at) {
    const HalfEdge half = *at;
    HalfEdge* to = at;
    for (; to > begin && to[-1] > half; --to) *to = to[-1];
    *to = half;
  }
}

bool HasRepeatedCorner(const mesh::Triangle& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

HalfEdges SortedHalfEdges(const mesh::TriangleMesh& mesh) {
  HalfEdges sorted;
  std::vector<std::uint32_t>& at = sorted.end;
  at.assign(mesh.vertices.size() + 1, 0);
  std::uint32_t count = 0;
  for (const mesh::Triangle& t : mesh.triangles) {
    if (HasRepeatedCorner(t)) continue;
    ++at[std::min(t[0], t[1]) + 1];
    ++at[std::min(t[1], t[2]) + 1];
    ++at[std::min(t[2], t[0]) + 1];
    count += 3;
  }
  std::partial_sum(at.begin(), at.end(), at.begin());
  sorted.edges.resize(count);
  // Each entry of `at` moves from the beginning of its vertex's half-edges to their end.
  std::uint32_t number = 0;
  const auto put = [&](std::uint32_t a, std::uint32_t b) {
    sorted.edges[at[std::min(a, b)]++] = Packed(std::max(a, b), number++, a < b);
  };
  for (const mesh::Triangle& t : mesh.triangles) {
    if (HasRepeatedCorner(t)) {
      number += 3;
      continue;
    }
    put(t[0], t[1]);
    put(t[1], t[2]);
    put(t[2], t[0]);
  }
  at.pop_back();
  return sorted;
}

/// Pairs the half-edges of an edge of more than two, opposite directions first.
void PairMany(std::span<const HalfEdge> edge, std::vector<std::uint32_t>& neighbours) {
  const auto join = [&](std::uint32_t a, std::uint32_t b) {
    neighbours[a] = b;
    neighbours[b] = a;
  };
  std::vector<std::uint32_t> up, down;
  for (const HalfEdge half : edge) {
    (IsUpward(half) ? up : down).push_back(NumberOf(half));
  }
  const std::size_t opposite = std::min(up.size(), down.size());
  for (std::size_t i = 0; i < opposite; ++i) join(up[i], down[i]);
  const std::vector<std::uint32_t>& left = up.size() > down.size() ? up : down;
  for (std::size_t i = opposite; i + 1 < left.size(); i += 2) join(left[i], left[i + 1]);
}

}  // namespace

std::vector<std::uint32_t> EdgeNeighbours(const mesh::TriangleMesh& mesh) {
  Require(mesh.triangles.size() < kMaxNeighbourTriangles,
          "too many triangles for their half-edges to be numbered: {}",
          mesh.triangles.size());
  auto [edges, end_of_vertex] = SortedHalfEdges(mesh);
  std::vector<std::uint32_t> neighbours(3 * mesh.triangles.size(), kNoNeighbour);
  std::size_t begin = 0;
  for (const std::uint32_t end_of_low : end_of_vertex) {
    SortFew(edges.data() + begin, edges.data() + end_of_low);
    while (begin < end_of_low) {
      std::size_t end = begin + 1;
      while (end < end_of_low && HighOf(edges[end]) == HighOf(edges[begin])) ++end;
      if (end - begin == 2) {
        const std::uint32_t a = NumberOf(edges[begin]), b = NumberOf(edges[begin + 1]);
        neighbours[a] = b;
        neighbours[b] = a;
      } else if (end - begin > 2) {
        PairMany(std::span(edges).subspan(begin, end - begin), neighbours);
      }
      begin = end;
    }
  }
  return neighbours;
}

}  // namespace intaglio::discretize
