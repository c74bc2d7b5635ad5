// All edges are divided where they meet, at one and the same point. Of a part the winding
// numbers wanted to its left and to its right tell how many loops run through it: their
// difference, against its direction when that is negative. Of parts that run along each
// other the one of the lowest edge stands for all. So as many loops come to a vertex as
// leave it, and a chain that does not close shows that a number was wrong: then the next
// tolerance is tried.

#include "engrave/contour/region/winding_loops.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "engrave/contour/crossings.h"
#include "engrave/contour/edge_tree.h"
#include "engrave/contour/fragments.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

/// Edges nearer than along_mm run along each other; numbers are asked for beside_mm from
/// the middle of a part.
struct Tolerance {
  double along_mm;
  double beside_mm;
};
constexpr Tolerance kTolerances[] = {{1e-7, 1e-6}, {2e-6, 1e-5}, {1e-9, 2e-8}};

struct DividingPoint {
  double way_mm;
  Vec2 place_mm;
};

class Divider {
 public:
  Divider(const Edges& edges, const std::vector<Pair>& pairs, double along_mm)
      : edges_(edges), along_mm_(along_mm), cuts_(edges.size()), shared_(edges.size()) {
    for (const Pair& pair : pairs) Meet(pair.first, pair.second);
  }

  /// Calls visit(part) for each part, of those along each other for one.
  template <typename Visit>
  void ForEachPart(const Visit& visit) {
    for (std::size_t k = 0; k < edges_.size(); ++k) {
      const Edge& edge = edges_[k];
      std::sort(cuts_[k].begin(), cuts_[k].end(),
                [](const auto& p, const auto& q) { return p.way_mm < q.way_mm; });
      DividingPoint begin{0, edge.begin_mm};
      for (std::size_t c = 0; c <= cuts_[k].size(); ++c) {
        const bool last = c == cuts_[k].size();
        const DividingPoint end =
            last ? DividingPoint{edge.length_mm, edge.end_mm} : cuts_[k][c];
        if (end.way_mm - begin.way_mm <= kVertex_mm && !last) continue;
        const double middle = 0.5 * (begin.way_mm + end.way_mm);
        const bool is_lowest = std::ranges::none_of(shared_[k], [&](const auto& part) {
          return part.begin_mm <= middle && middle <= part.end_mm;
        });
        if (is_lowest && end.way_mm > begin.way_mm)
          visit(PartOf(edge, begin.way_mm, end.way_mm, begin.place_mm, end.place_mm));
        begin = end;
      }
    }
  }

 private:
  void Meet(std::uint32_t ka, std::uint32_t kb) {
    const Edge& a = edges_[ka];
    const Edge& b = edges_[kb];
    points_.clear();
    AppendCrossings(a, b, points_);
    for (const Vec2& end : {b.begin_mm, b.end_mm})
      if (DistanceTo(a, end) < kVertex_mm) points_.push_back(end);
    for (const Vec2& end : {a.begin_mm, a.end_mm})
      if (DistanceTo(b, end) < kVertex_mm) points_.push_back(end);
    for (const Vec2& point : points_) {
      Cut(ka, point);
      Cut(kb, point);
    }
    AppendSharedParts(b, a, along_mm_, shared_[kb]);
  }

  void Cut(std::uint32_t k, const Vec2& point) {
    const double way = WayTo(edges_[k], point);
    if (way > kVertex_mm && way < edges_[k].length_mm - kVertex_mm)
      cuts_[k].push_back({way, point});
  }

  const Edges& edges_;
  double along_mm_;
  std::vector<std::vector<DividingPoint>> cuts_;
  std::vector<std::vector<SharedPart>> shared_;  ///< with lower edges
  std::vector<Vec2> points_;
};

/// Whether nothing but rounding is between the loop's edges. The sums of triangles count
/// for loops whose parts run around in both directions.
bool IsThin(const Edges& loop) {
  const Vec2& from = loop.front().begin_mm;
  double twice = 0, largest = 0;
  for (const Edge& edge : loop) {
    twice += TwiceSweptArea(edge) + Cross(edge.end_mm - edge.begin_mm, from);
    largest = std::max(largest, std::abs(twice));
  }
  return largest <= 8 * kVertex_mm * LengthOf(loop);
}

/// The loops; nothing when one does not close, at `open`.
std::optional<std::vector<Edges>> Closed(const std::vector<Fragment>& fragments,
                                         std::optional<Vec2>& open) {
  std::vector<Edges> loops;
  for (const ChainedContour& contour : Chain(fragments)) {
    if (!contour.closed) {
      if (!open) open = fragments[contour.fragments.back()].edge.end_mm;
      return std::nullopt;
    }
    Edges loop = Joined(fragments, contour.fragments);
    if (!IsThin(loop)) loops.push_back(std::move(loop));
  }
  return loops;
}

Result<std::vector<Pair>> PairsOf(const Edges& edges, std::uint64_t& left) {
  const EdgeTree tree(edges);
  const Vec2 slack = Vec2::Constant(4 * kVertex_mm);
  std::vector<Pair> pairs;
  for (std::uint32_t k = 0; k < edges.size(); ++k) {
    FlatBox box = FlatBoxOf(edges[k]);
    box.min_mm -= slack;
    box.max_mm += slack;
    const std::vector<std::uint32_t> near = tree.EdgesIn(box);
    if (near.size() > left) {
      left = 0;
      return Fail(ErrorCode::kTooLarge, "too many edges cross each other");
    }
    left -= near.size();
    for (const std::uint32_t other : near)
      if (other > k) pairs.push_back({k, other});
  }
  return pairs;
}

}  // namespace

Result<std::vector<Edges>> LoopsOfWinding(const Edges& edges, const WindingAt& winding_at,
                                          std::uint64_t& pairs_left) {
  if (edges.empty()) return std::vector<Edges>();
  const std::vector<Pair> pairs = INTAGLIO_TRY(PairsOf(edges, pairs_left));
  std::optional<Vec2> open;
  for (const Tolerance& tolerance : kTolerances) {
    std::vector<Fragment> fragments;
    Divider(edges, pairs, tolerance.along_mm).ForEachPart([&](const Edge& part) {
      const double half = part.length_mm / 2;
      const Vec2 beside = tolerance.beside_mm * RightOf(DirectionAt(part, half));
      const Vec2 middle = PointAt(part, half);
      const int times = winding_at(middle - beside) - winding_at(middle + beside);
      // A number each: where parts meet the sharpest turn to the left decides.
      for (int i = 0; i < std::abs(times); ++i)
        fragments.push_back({times > 0 ? part : Reversed(part),
                             static_cast<std::uint32_t>(fragments.size())});
    });
    if (auto loops = Closed(fragments, open)) return std::move(*loops);
  }
  return Fail(ErrorCode::kUnsupported,
              fmt::format("edges nearly touch at ({:.6f}, {:.6f}) mm and cannot be told "
                          "apart",
                          open->x(), open->y()));
}

}  // namespace intaglio::contour
