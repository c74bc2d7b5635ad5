#include "engrave/contour/region/loose_edges.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace intaglio::contour {
namespace {

constexpr double kNoLength_mm = 1e-6;

/// Ends of edges, in squares as wide as the tolerance.
class LooseEnds {
 public:
  struct End {
    Vec2 place;
    std::uint32_t edge = UINT32_MAX;
    bool at_end = false;
  };

  LooseEnds(const Edges& edges, double tolerance_mm) : tolerance_(tolerance_mm) {
    for (std::uint32_t k = 0; k < edges.size(); ++k) {
      for (const bool at_end : {false, true}) {
        const Vec2 place = at_end ? edges[k].end_mm : edges[k].begin_mm;
        squares_[Key(Square(place.x()), Square(place.y()))].push_back({place, k, at_end});
      }
    }
  }

  End Nearest(const Vec2& place, const std::vector<char>& used) const {
    End nearest;
    double distance = tolerance_;
    for (std::int64_t x = -1; x <= 1; ++x) {
      for (std::int64_t y = -1; y <= 1; ++y) {
        const auto found =
            squares_.find(Key(Square(place.x()) + x, Square(place.y()) + y));
        if (found == squares_.end()) continue;
        for (const End& end : found->second) {
          if (used[end.edge] || (end.place - place).norm() > distance) continue;
          if (nearest.edge != UINT32_MAX && (end.place - place).norm() == distance)
            continue;
          distance = (end.place - place).norm();
          nearest = end;
        }
      }
    }
    return nearest;
  }

 private:
  std::int64_t Square(double x) const {
    return static_cast<std::int64_t>(std::floor(x / tolerance_));
  }
  static std::uint64_t Key(std::int64_t x, std::int64_t y) {
    return static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15U ^
           static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4FU;
  }
  double tolerance_;
  std::unordered_map<std::uint64_t, std::vector<End>> squares_;
};

/// The edge drawn behind or in front of the last one, where it begins or ends at this
/// very place; else none.
LooseEnds::End GoesOn(const Edges& edges, const std::vector<char>& used,
                      std::uint32_t last, const Vec2& place) {
  const std::uint32_t next = last + 1;
  if (next < edges.size() && used[next] == 0 &&
      (edges[next].begin_mm - place).norm() <= kNoLength_mm)
    return {edges[next].begin_mm, next, false};
  if (last > 0 && used[last - 1] == 0 &&
      (edges[last - 1].end_mm - place).norm() <= kNoLength_mm)
    return {edges[last - 1].end_mm, last - 1, true};
  return {};
}

Edge MovedEnds(const Edge& edge, const Vec2& begin, const Vec2& end) {
  if (!edge.is_arc()) return MakeLine(begin, end);
  if (begin == end) return edge;
  // The centre goes to where both ends are equally far.
  const Vec2 along = (end - begin).normalized();
  const Vec2 center =
      edge.center_mm + along * along.dot(0.5 * (begin + end) - edge.center_mm);
  return MakeArcBetween(begin, end, center, edge.sweep_rad > 0);
}

}  // namespace

Result<std::vector<Edges>> JoinLoops(const Edges& all, double tolerance_mm) {
  Edges edges;
  for (const Edge& edge : all) {
    if (edge.length_mm > kNoLength_mm) edges.push_back(edge);
  }
  const LooseEnds ends(edges, tolerance_mm);
  std::vector<char> used(edges.size(), 0);
  std::vector<Edges> loops;
  for (std::uint32_t first = 0; first < edges.size(); ++first) {
    if (used[first]) continue;
    used[first] = 1;
    Edges loop{edges[first]};
    const Vec2 start = edges[first].begin_mm;
    std::uint32_t last = first;
    while (true) {
      auto next = GoesOn(edges, used, last, loop.back().end_mm);
      const double to_start_mm = (loop.back().end_mm - start).norm();
      const bool comes_back = to_start_mm <= tolerance_mm &&
                              (loop.size() > 1 || loop[0].length_mm > tolerance_mm);
      // Short edges are near the start before the drawn curve is.
      if (comes_back && (next.edge == UINT32_MAX || to_start_mm <= kNoLength_mm)) break;
      if (next.edge == UINT32_MAX) next = ends.Nearest(loop.back().end_mm, used);
      if (next.edge == UINT32_MAX) {
        const Vec2& at = loop.back().end_mm;
        return Fail(ErrorCode::kInvalidValue,
                    fmt::format("a contour is open at ({:.6g}, {:.6g}); close it", at.x(),
                                at.y()),
                    fmt::format("{:.6g}, {:.6g}", at.x(), at.y()));
      }
      used[next.edge] = 1;
      last = next.edge;
      const Edge& edge = edges[next.edge];
      const Edge turned = next.at_end ? Reversed(edge) : edge;
      loop.push_back(MovedEnds(turned, loop.back().end_mm, turned.end_mm));
    }
    if (loop.size() > 1)
      loop.back() = MovedEnds(loop.back(), loop.back().begin_mm, start);
    loops.push_back(std::move(loop));
  }
  return loops;
}

}  // namespace intaglio::contour
