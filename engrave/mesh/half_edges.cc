#include "engrave/mesh/half_edges.h"

#include <algorithm>
#include <numeric>

#include "engrave/core/check.h"

namespace intaglio::mesh {

HalfEdges::HalfEdges(const TriangleMesh& mesh) {
  Require(mesh.triangles.size() <= kMaxHalfEdgeTriangles,
          "too many triangles for their half-edges to be numbered: {}",
          mesh.triangles.size());
  std::vector<std::uint32_t>& at = end_of_low_;
  at.assign(mesh.vertices.size() + 1, 0);
  std::uint32_t count = 0;
  for (const Triangle& t : mesh.triangles) {
    if (HasRepeatedCorner(t)) continue;
    ++at[std::min(t[0], t[1]) + 1];
    ++at[std::min(t[1], t[2]) + 1];
    ++at[std::min(t[2], t[0]) + 1];
    count += 3;
  }
  std::partial_sum(at.begin(), at.end(), at.begin());
  half_edges_.resize(count);
  // Each entry of `at` moves from the beginning of its vertex's half-edges to their end.
  std::uint32_t number = 0;
  const auto put = [&](std::uint32_t a, std::uint32_t b) {
    half_edges_[at[std::min(a, b)]++] = HalfEdge(std::max(a, b), number++, a < b);
  };
  for (const Triangle& t : mesh.triangles) {
    if (HasRepeatedCorner(t)) {
      number += 3;
      continue;
    }
    put(t[0], t[1]);
    put(t[1], t[2]);
    put(t[2], t[0]);
  }
  at.pop_back();
}

void HalfEdges::SortThoseOf(std::size_t begin, std::size_t end) {
  constexpr std::size_t kFew = 24;  // mostly there are six or so
  HalfEdge* const first = half_edges_.data() + begin;
  HalfEdge* const last = half_edges_.data() + end;
  if (end - begin > kFew) return std::sort(first, last);
  for (HalfEdge* at = first; at < last; ++at) {
    const HalfEdge half = *at;
    HalfEdge* to = at;
    for (; to > first && half < to[-1]; --to) *to = to[-1];
    *to = half;
  }
}

}  // namespace intaglio::mesh
