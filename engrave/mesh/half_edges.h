#pragma once

// The edges of a mesh, each with the sides of triangles that lie on it, in linear time.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/mesh/mesh.h"

namespace intaglio::mesh {

/// Far above the limit of an import; the numbers of half-edges times 2 fit 32 bits.
inline constexpr std::size_t kMaxHalfEdgeTriangles = std::size_t{1} << 28;

/// A triangle's side, from corner `side` to the next one.
class HalfEdge {
 public:
  HalfEdge() = default;
  /// `high`: the higher of its two vertices; `upward`: from the lower to that one.
  HalfEdge(std::uint32_t high, std::uint32_t number, bool upward)
      : packed_(std::uint64_t{high} << 32 | std::uint64_t{number} << 1 |
                (upward ? 1 : 0)) {}

  std::uint32_t high() const { return static_cast<std::uint32_t>(packed_ >> 32); }
  /// 3 * triangle + side.
  std::uint32_t number() const { return static_cast<std::uint32_t>(packed_) >> 1; }
  bool upward() const { return (packed_ & 1) != 0; }
  std::uint32_t triangle() const { return number() / 3; }

  bool operator<(HalfEdge other) const { return packed_ < other.packed_; }

 private:
  std::uint64_t packed_ = 0;
};

inline bool HasRepeatedCorner(const Triangle& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

/// The half-edges of a mesh by the lower vertex of their edge. A triangle with a repeated
/// corner has none.
class HalfEdges {
 public:
  /// No more triangles than kMaxHalfEdgeTriangles.
  explicit HalfEdges(const TriangleMesh& mesh);

  /// Calls visit(low, half_edges) for each edge, by its lower and then its higher vertex,
  /// with a span of its HalfEdge by their numbers.
  template <typename Visit>
  void ForEachEdge(const Visit& visit);

 private:
  /// By higher vertex and number.
  void SortThoseOf(std::size_t begin, std::size_t end);

  std::vector<HalfEdge> half_edges_;
  std::vector<std::uint32_t> end_of_low_;  // in half_edges_
};

template <typename Visit>
void HalfEdges::ForEachEdge(const Visit& visit) {
  std::size_t begin = 0;
  for (std::uint32_t low = 0; low < end_of_low_.size(); ++low) {
    const std::size_t end_of_low = end_of_low_[low];
    SortThoseOf(begin, end_of_low);
    while (begin < end_of_low) {
      std::size_t end = begin + 1;
      while (end < end_of_low && half_edges_[end].high() == half_edges_[begin].high()) {
        ++end;
      }
      visit(low, std::span<const HalfEdge>(&half_edges_[begin], end - begin));
      begin = end;
    }
  }
}

}  // namespace intaglio::mesh
