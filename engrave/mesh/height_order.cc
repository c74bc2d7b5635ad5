#include "engrave/mesh/height_order.h"

#include <algorithm>

namespace intaglio::mesh {
namespace {

/// The new place of each of `count` things by their keys, of which there are key_count:
/// by counting, equal ones in the old order.
template <typename KeyOf>
std::vector<std::uint32_t> Places(std::size_t count, std::size_t key_count,
                                  const KeyOf& key_of) {
  std::vector<std::uint32_t> next(key_count + 1, 0);
  for (std::size_t i = 0; i < count; ++i) ++next[key_of(i) + 1];
  for (std::size_t key = 0; key < key_count; ++key) next[key + 1] += next[key];
  std::vector<std::uint32_t> place(count);
  for (std::size_t i = 0; i < count; ++i) place[i] = next[key_of(i)]++;
  return place;
}

}  // namespace

void OrderByRank(TriangleMesh& mesh, std::vector<std::uint32_t>& rank,
                 std::uint32_t rank_count) {
  // No more keys than vertices.
  int shift = 0;
  while ((rank_count >> shift) > mesh.vertices.size()) ++shift;
  const std::size_t key_count = (rank_count >> shift) + 1;
  const std::vector<std::uint32_t> place = Places(
      mesh.vertices.size(), key_count, [&](std::size_t v) { return rank[v] >> shift; });
  PointList vertices(mesh.vertices.size());
  std::vector<std::uint32_t> ordered_rank(rank.size());
  for (std::size_t v = 0; v < place.size(); ++v) {
    vertices[place[v]] = mesh.vertices[v];
    ordered_rank[place[v]] = rank[v];
  }
  mesh.vertices = std::move(vertices);
  rank = std::move(ordered_rank);
  for (Triangle& t : mesh.triangles) t = {place[t[0]], place[t[1]], place[t[2]]};
  const std::vector<std::uint32_t> triangle_place =
      Places(mesh.triangles.size(), key_count, [&](std::size_t i) {
        const Triangle& t = mesh.triangles[i];
        return std::min({rank[t[0]], rank[t[1]], rank[t[2]]}) >> shift;
      });
  std::vector<Triangle> triangles(mesh.triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    triangles[triangle_place[i]] = mesh.triangles[i];
  }
  mesh.triangles = std::move(triangles);
}

}  // namespace intaglio::mesh
