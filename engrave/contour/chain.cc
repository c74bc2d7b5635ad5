#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "engrave/contour/fragments.h"
#include "engrave/core/geometry.h"

namespace intaglio::contour {
namespace {

constexpr std::uint32_t kNone = UINT32_MAX;
constexpr double kSameCarrier_mm = 1e-6;

/// Numbers places; those nearer than kVertex_mm have one number. A square of the grid is
/// far wider than that, so nearly every place is searched in one square only.
class Vertices {
 public:
  explicit Vertices(std::size_t expected) { squares_.reserve(expected); }

  std::uint32_t Number(const Vec2& place) {
    const std::int64_t left = Square(place.x() - kVertex_mm);
    const std::int64_t right = Square(place.x() + kVertex_mm);
    const std::int64_t low = Square(place.y() - kVertex_mm);
    const std::int64_t high = Square(place.y() + kVertex_mm);
    for (std::int64_t x = left; x <= right; ++x) {
      for (std::int64_t y = low; y <= high; ++y) {
        const auto found = squares_.find(Key(x, y));
        if (found == squares_.end()) continue;
        for (std::uint32_t v = found->second; v != kNone; v = next_[v]) {
          if ((places_[v] - place).norm() < kVertex_mm) return v;
        }
      }
    }
    const auto number = static_cast<std::uint32_t>(places_.size());
    places_.push_back(place);
    const auto [at, added] =
        squares_.try_emplace(Key(Square(place.x()), Square(place.y())), number);
    next_.push_back(added ? kNone : at->second);
    at->second = number;
    return number;
  }

  std::size_t size() const { return places_.size(); }

 private:
  static std::int64_t Square(double x) {
    return static_cast<std::int64_t>(std::floor(x * (1 / (256 * kVertex_mm))));
  }
  static std::uint64_t Key(std::int64_t x, std::int64_t y) {
    const auto mixed = static_cast<std::uint64_t>(x) * 0x9E3779B97F4A7C15U ^
                       static_cast<std::uint64_t>(y) * 0xC2B2AE3D27D4EB4FU;
    return mixed ^ (mixed >> 29);
  }
  std::unordered_map<std::uint64_t, std::uint32_t> squares_;
  std::vector<std::uint32_t> next_;  ///< in the same square
  std::vector<Vec2> places_;
};

/// Fragments by the vertex where they begin.
class Chainer {
 public:
  explicit Chainer(std::span<const Fragment> fragments)
      : fragments_(fragments), used_(fragments.size(), 0) {
    Vertices vertices(2 * fragments.size());
    for (const Fragment& f : fragments) {
      begins_.push_back(vertices.Number(f.edge.begin_mm));
      ends_.push_back(vertices.Number(f.edge.end_mm));
    }
    first_.assign(vertices.size(), kNone);
    next_.assign(fragments.size(), kNone);
    for (auto f = static_cast<std::uint32_t>(fragments.size()); f-- > 0;) {
      next_[f] = first_[begins_[f]];
      first_[begins_[f]] = f;
    }
  }

  std::vector<ChainedContour> Run() {
    std::vector<ChainedContour> contours;
    for (std::uint32_t f = 0; f < fragments_.size(); ++f) {
      // What is left over of two outlines that touch: both ends are one vertex.
      const bool tiny =
          begins_[f] == ends_[f] && fragments_[f].edge.length_mm < 3 * kVertex_mm;
      if (!used_[f] && !tiny) contours.push_back(From(f));
    }
    return contours;
  }

 private:
  ChainedContour From(std::uint32_t begin) {
    ChainedContour contour;
    for (std::uint32_t f = begin; f != kNone; f = Next(f)) {
      used_[f] = 1;
      contour.fragments.push_back(f);
      contour.closed = ends_[f] == begins_[begin];
      if (contour.closed) break;
    }
    return contour;
  }

  std::uint32_t Next(std::uint32_t from) const {
    std::uint32_t next = kNone;
    double sharpest = -10;
    const Edge& edge = fragments_[from].edge;
    for (std::uint32_t f = first_[ends_[from]]; f != kNone; f = next_[f]) {
      if (used_[f]) continue;
      if (next == kNone && next_[f] == kNone) return f;
      const Vec2 in = DirectionAt(edge, edge.length_mm);
      const Vec2 out = DirectionAt(fragments_[f].edge, 0);
      double turn = std::atan2(Cross(in, out), in.dot(out));
      if (fragments_[f].area == fragments_[from].area) turn = 10;
      if (turn > sharpest) {
        sharpest = turn;
        next = f;
      }
    }
    return next;
  }

  std::span<const Fragment> fragments_;
  std::vector<char> used_;
  std::vector<std::uint32_t> begins_;  ///< vertex, of each fragment
  std::vector<std::uint32_t> ends_;
  std::vector<std::uint32_t> first_;  ///< fragment, of each vertex
  std::vector<std::uint32_t> next_;   ///< fragment with the same first vertex
};

bool GoOn(const Edge& a, const Edge& b) {
  if (a.is_arc() != b.is_arc()) return false;
  if (a.is_arc()) {
    return (a.center_mm - b.center_mm).norm() < kSameCarrier_mm &&
           std::abs(a.radius_mm - b.radius_mm) < kSameCarrier_mm &&
           (a.sweep_rad > 0) == (b.sweep_rad > 0);
  }
  const Vec2 along = (a.end_mm - a.begin_mm) / a.length_mm;
  return std::abs(Cross(along, b.end_mm - a.end_mm)) < kSameCarrier_mm &&
         along.dot(b.end_mm - b.begin_mm) > 0;
}

Edge JoinedPair(const Edge& a, const Edge& b) {
  if (!a.is_arc()) return MakeLine(a.begin_mm, b.end_mm);
  Edge joined = a;
  joined.end_mm = b.end_mm;
  joined.sweep_rad += b.sweep_rad;
  joined.length_mm += b.length_mm;
  return joined;
}

/// Lets every edge begin exactly where the one before ends, with arcs that fit.
void CloseGaps(Edges& edges) {
  if (edges.size() < 2) return;
  for (std::size_t k = 0; k < edges.size(); ++k)
    edges[(k + 1) % edges.size()].begin_mm = edges[k].end_mm;
  for (Edge& edge : edges) {
    if (!edge.is_arc()) {
      edge = MakeLine(edge.begin_mm, edge.end_mm);
      continue;
    }
    const Vec2 from = edge.begin_mm - edge.center_mm;
    const Vec2 to = edge.end_mm - edge.center_mm;
    const double turn = std::atan2(Cross(from, to), from.dot(to));
    edge.begin_rad = std::atan2(from.y(), from.x());
    edge.sweep_rad = turn + kTwoPi * std::round((edge.sweep_rad - turn) / kTwoPi);
    edge.length_mm = edge.radius_mm * std::abs(edge.sweep_rad);
  }
}

}  // namespace

std::vector<ChainedContour> Chain(std::span<const Fragment> fragments) {
  return Chainer(fragments).Run();
}

Edges Joined(std::span<const Fragment> fragments,
             std::span<const std::uint32_t> contour) {
  Edges edges;
  for (const std::uint32_t f : contour) {
    const Edge& edge = fragments[f].edge;
    if (!edges.empty() && GoOn(edges.back(), edge)) {
      edges.back() = JoinedPair(edges.back(), edge);
    } else {
      edges.push_back(edge);
    }
  }
  if (edges.size() > 1 && GoOn(edges.back(), edges.front())) {
    edges.front() = JoinedPair(edges.back(), edges.front());
    edges.pop_back();
  }
  CloseGaps(edges);
  return edges;
}

}  // namespace intaglio::contour
