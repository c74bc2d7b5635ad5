// Both regions' edges are divided where they meet, at one and the same point, and each
// part lies inside, outside or on the border of the other region. Of a the parts outside
// and of b those inside, turned round, enclose the difference; of both the parts inside
// the intersection. A part on which both borders run is decided once, by its direction.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engrave/contour/crossings.h"
#include "engrave/contour/fragments.h"
#include "engrave/contour/near_pairs.h"
#include "engrave/contour/region/region_index.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

// As of unions: edges nearer than the first run along each other; where that leaves the
// proof unsatisfied the next is tried.
constexpr double kAlong_mm[] = {1e-7, 1e-9, 2e-6, 4e-6};
constexpr double kBoxMargin_mm = 1e-4;
constexpr double kParallel = 0.9;  // cosine

struct PlaceOnEdge {
  double way_mm;
  Vec2 place_mm;
};

struct DividedEdge {
  std::vector<PlaceOnEdge> cuts;
  std::vector<std::uint32_t> near;  ///< edges of the other region
};

enum class Side { kInside, kOutside, kSame, kOpposite };

/// What is wrong, and where.
struct Misfit {
  Vec2 place_mm;
};

bool IsNearEdge(const Edge& edge, const Vec2& point) {
  return DistanceTo(edge, point) < kVertex_mm;
}

class Combiner {
 public:
  Combiner(const RegionIndex& a, const RegionIndex& b, std::span<const Pair> pairs,
           double along_mm)
      : a_(a), b_(b), along_mm_(along_mm) {
    of_a_.resize(a.edges().size());
    of_b_.resize(b.edges().size());
    for (const Pair& pair : pairs)
      Meet(pair.first, pair.second - static_cast<std::uint32_t>(a.edges().size()));
  }

  /// Nothing where the proof fails: then misfit() tells the place.
  std::optional<Combined> Run() {
    Sort(a_, of_a_, b_, true);
    Sort(b_, of_b_, a_, false);
    Combined combined;
    if (misfit_ || !Close(outside_, combined.outside) || !Close(inside_, combined.inside))
      return std::nullopt;
    combined.inside_area_mm2 = AreaOf(combined.inside);
    const double sum = AreaOf(combined.outside) + combined.inside_area_mm2;
    const double allowed = 1e-6 + 2 * std::max(along_mm_, 1e-7) * length_mm_;
    if (std::abs(sum - a_.area_mm2()) <= allowed) return combined;
    misfit_ = Misfit{a_.edges().front().begin_mm};
    return std::nullopt;
  }

  Misfit misfit() const { return misfit_.value_or(Misfit{Vec2::Zero()}); }

 private:
  void Meet(std::uint32_t ka, std::uint32_t kb) {
    const Edge& a = a_.edges()[ka];
    const Edge& b = b_.edges()[kb];
    std::vector<Vec2> points;
    AppendCrossings(a, b, points);
    for (const Vec2& end : {b.begin_mm, b.end_mm})
      if (IsNearEdge(a, end)) points.push_back(end);
    for (const Vec2& end : {a.begin_mm, a.end_mm})
      if (IsNearEdge(b, end)) points.push_back(end);
    for (const Vec2& point : points) {
      Cut(a, of_a_[ka], point);
      Cut(b, of_b_[kb], point);
    }
    of_a_[ka].near.push_back(kb);
    of_b_[kb].near.push_back(ka);
  }

  static void Cut(const Edge& edge, DividedEdge& divided, const Vec2& point) {
    const double way = WayTo(edge, point);
    if (way > kVertex_mm && way < edge.length_mm - kVertex_mm)
      divided.cuts.push_back({way, point});
  }

  void Sort(const RegionIndex& region, std::vector<DividedEdge>& divided,
            const RegionIndex& other, bool is_a) {
    for (std::size_t k = 0; k < region.edges().size(); ++k) {
      const Edge& edge = region.edges()[k];
      auto& cuts = divided[k].cuts;
      std::sort(cuts.begin(), cuts.end(), [](const PlaceOnEdge& p, const PlaceOnEdge& q) {
        return p.way_mm < q.way_mm;
      });
      PlaceOnEdge begin{0, edge.begin_mm};
      for (std::size_t c = 0; c <= cuts.size(); ++c) {
        const PlaceOnEdge end =
            c < cuts.size() ? cuts[c] : PlaceOnEdge{edge.length_mm, edge.end_mm};
        if (end.way_mm - begin.way_mm <= kVertex_mm && c < cuts.size()) continue;
        if (end.way_mm > begin.way_mm) {
          const Edge part =
              PartOf(edge, begin.way_mm, end.way_mm, begin.place_mm, end.place_mm);
          Place(part, SideOf(part, divided[k].near, other), is_a);
        }
        begin = end;
      }
    }
  }

  /// A part is cut where edges of the other region end or cross it, so it runs along one
  /// of them wholly or nowhere: its ends and its middle are near to it.
  Side SideOf(const Edge& part, const std::vector<std::uint32_t>& near,
              const RegionIndex& other) {
    const Vec2 middle = PointAt(part, part.length_mm / 2);
    for (const std::uint32_t k : near) {
      const Edge& edge = other.edges()[k];
      if (DistanceTo(edge, middle) > along_mm_ ||
          DistanceTo(edge, part.begin_mm) > kVertex_mm + along_mm_ ||
          DistanceTo(edge, part.end_mm) > kVertex_mm + along_mm_)
        continue;
      const double way = std::clamp(WayTo(edge, middle), 0.0, edge.length_mm);
      const double turn =
          DirectionAt(edge, way).dot(DirectionAt(part, part.length_mm / 2));
      if (std::abs(turn) < kParallel) continue;
      return turn > 0 ? Side::kSame : Side::kOpposite;
    }
    const bool inside = other.IsInside(middle);
    // Parts of a few vertices' length are as their middle.
    if (part.length_mm < 16 * kVertex_mm) return inside ? Side::kInside : Side::kOutside;
    for (const double at : {0.25, 0.75}) {
      const Vec2 place = PointAt(part, at * part.length_mm);
      if (other.IsInside(place) != inside) misfit_ = Misfit{place};
    }
    return inside ? Side::kInside : Side::kOutside;
  }

  void Place(const Edge& part, Side side, bool is_a) {
    length_mm_ += part.length_mm;
    if (side == Side::kInside) {
      Append(inside_, part);
      if (!is_a) Append(outside_, Reversed(part));
    } else if (is_a && side == Side::kSame) {
      Append(inside_, part);
    } else if (is_a) {
      Append(outside_, part);
    }
  }

  /// A number each: where parts meet the sharpest turn to the left decides.
  static void Append(std::vector<Fragment>& fragments, const Edge& part) {
    fragments.push_back({part, static_cast<std::uint32_t>(fragments.size())});
  }

  bool Close(const std::vector<Fragment>& fragments, Region& region) {
    for (const ChainedContour& contour : Chain(fragments)) {
      if (!contour.closed) {
        misfit_ = Misfit{fragments[contour.fragments.back()].edge.end_mm};
        return false;
      }
      Edges loop = Joined(fragments, contour.fragments);
      if (std::abs(AreaOf(loop)) > 4 * kVertex_mm * LengthOf(loop))
        region.loops.push_back(std::move(loop));
    }
    return true;
  }

  const RegionIndex& a_;
  const RegionIndex& b_;
  double along_mm_;
  std::vector<DividedEdge> of_a_;
  std::vector<DividedEdge> of_b_;
  std::vector<Fragment> outside_;
  std::vector<Fragment> inside_;
  std::optional<Misfit> misfit_;
  double length_mm_ = 0;
};

/// The pairs of an edge of each region that may meet; b's edges are numbered behind a's.
std::vector<Pair> PairsAcross(const RegionIndex& a, const RegionIndex& b) {
  std::vector<FlatBox> boxes;
  for (const RegionIndex* region : {&a, &b}) {
    for (const Edge& edge : region->edges()) {
      const EdgeBox box = BoxOfEdge(edge);
      boxes.push_back({box.min_mm, box.max_mm});
    }
  }
  std::vector<Pair> pairs = NearPairs(boxes, kBoxMargin_mm);
  const auto of_a = static_cast<std::uint32_t>(a.edges().size());
  std::erase_if(
      pairs, [&](const Pair& pair) { return pair.first >= of_a || pair.second < of_a; });
  return pairs;
}

}  // namespace

Result<Combined> Combine(const Region& a, const Region& b) {
  if (a.loops.empty()) return Combined{};
  if (b.loops.empty()) return Combined{a, {}, 0};
  const RegionIndex first(a);
  const RegionIndex second(b);
  const std::vector<Pair> pairs = PairsAcross(first, second);
  std::optional<Misfit> misfit;
  for (const double along_mm : kAlong_mm) {
    Combiner combiner(first, second, pairs, along_mm);
    if (auto combined = combiner.Run()) return std::move(*combined);
    if (!misfit) misfit = combiner.misfit();
  }
  const Vec2& at = misfit->place_mm;
  return Fail(
      ErrorCode::kUnsupported,
      fmt::format("two contours nearly touch at ({:.6f}, {:.6f}) mm and cannot be "
                  "told apart; move or resize one of them there by 0.001 mm",
                  at.x(), at.y()),
      fmt::format("{:.6f}, {:.6f}", at.x(), at.y()));
}

Result<Region> Difference(const Region& a, const Region& b) {
  Combined combined = INTAGLIO_TRY(Combine(a, b));
  return std::move(combined.outside);
}

Result<Region> Intersection(const Region& a, const Region& b) {
  Combined combined = INTAGLIO_TRY(Combine(a, b));
  return std::move(combined.inside);
}

}  // namespace intaglio::contour
