// Let a line of length s join two points of the border. A centre at least r from both is
// at least sqrt(r^2 - s^2 / 4) from the line, s^2 / (8 r) less than r. A disc that lies
// partly beyond the line leaves but a cap of this height on this side of it, so a part
// with less than 0.9 of the disc's area has none; and no disc lies wholly in such a part
// that is now outside, nor in one that is now inside: it has at most as much.
//
// The part is cut off where the line crosses no edge and the run with the line back
// encloses an area counter-clockwise: the region is to the left of the run. A line begins
// in a corner and ends anywhere on what is left of the border; so there is a second
// search, against the direction of the loops. No line begins or ends on another one, so
// that their errors do not add up.

#include "engrave/contour/region/bays.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "engrave/contour/edge_tree.h"

namespace intaglio::contour {
namespace {

constexpr double kShareOfDisc = 0.9;
constexpr double kOnLine_mm = 1e-9;
// Lines from a corner that are compared with edges.
constexpr int kLinesACorner = 12;

/// A loop, and which of its edges are lines that were put in.
struct CutLoop {
  Edges edges;
  std::vector<char> is_cut;
};

/// The area of runs of a loop, closed by a line, in constant time.
class RunAreas {
 public:
  explicit RunAreas(const Edges& loop) : loop_(loop), origin_(loop.front().begin_mm) {
    sums_.push_back(0);
    for (const Edge& edge : loop)
      sums_.push_back(sums_.back() +
                      Cross(edge.begin_mm - origin_, edge.end_mm - origin_));
  }
  /// From the begin of edge `first` to a place on edge `last`, first < last.
  double Closed_mm2(std::size_t first, std::size_t last, const Vec2& place_mm) const {
    const Vec2 begin_mm = loop_[first].begin_mm - origin_;
    const Vec2 last_mm = loop_[last].begin_mm - origin_;
    const Vec2 end_mm = place_mm - origin_;
    return 0.5 * (sums_[last] - sums_[first] + Cross(last_mm, end_mm) +
                  Cross(end_mm, begin_mm));
  }

 private:
  const Edges& loop_;
  Vec2 origin_;
  std::vector<double> sums_;
};

Edges EdgesOf(const std::vector<CutLoop>& loops) {
  Edges edges;
  for (const CutLoop& loop : loops)
    edges.insert(edges.end(), loop.edges.begin(), loop.edges.end());
  return edges;
}

class BayCutter {
 public:
  BayCutter(const std::vector<CutLoop>& loops, double disc_mm, double neck_mm)
      : edges_(EdgesOf(loops)),
        tree_(edges_),
        neck_mm_(neck_mm),
        max_mm2_(kShareOfDisc * std::numbers::pi * disc_mm * disc_mm) {}

  /// Of the loops in their order.
  CutLoop Cut(const CutLoop& loop) {
    const RunAreas areas(loop.edges);
    CutLoop cut;
    for (std::size_t k = 0; k < loop.edges.size();) {
      const End end = EndOfRun(loop, k, areas);
      const Edge& last = loop.edges[end.edge];
      if (end.edge > k) Append(cut, MakeLine(loop.edges[k].begin_mm, end.place_mm), true);
      if (end.edge == k || end.place_mm != last.end_mm)
        Append(cut, MakeLine(end.edge == k ? last.begin_mm : end.place_mm, last.end_mm),
               loop.is_cut[end.edge] != 0);
      k = end.edge + 1;
    }
    first_edge_ += loop.edges.size();
    return cut;
  }

 private:
  struct End {
    std::size_t edge = 0;  ///< of the loop
    double way_mm = 0;
    Vec2 place_mm = Vec2::Zero();
  };

  static void Append(CutLoop& cut, const Edge& line, bool is_cut) {
    cut.edges.push_back(line);
    cut.is_cut.push_back(is_cut ? 1 : 0);
  }

  /// Where a line from the begin of edge `first` ends; on that edge: there is none.
  End EndOfRun(const CutLoop& loop, std::size_t first, const RunAreas& areas) {
    const Vec2& begin_mm = loop.edges[first].begin_mm;
    FindEnds(loop, first);
    int lines_left = kLinesACorner;
    for (const End& end : ends_) {
      const double area_mm2 = areas.Closed_mm2(first, end.edge, end.place_mm);
      if (area_mm2 <= 0 || area_mm2 > max_mm2_) continue;
      if (!Crosses(begin_mm, end.place_mm)) return end;
      if (--lines_left == 0) break;
    }
    return {first, 0, begin_mm};
  }

  /// Of the edges behind the first one within the neck the nearest place and both ends,
  /// those farthest along the loop first.
  void FindEnds(const CutLoop& loop, std::size_t first) {
    const Vec2& begin_mm = loop.edges[first].begin_mm;
    const Vec2 reach = Vec2::Constant(neck_mm_);
    ends_.clear();
    for (const std::uint32_t k : tree_.EdgesIn({begin_mm - reach, begin_mm + reach})) {
      if (k <= first_edge_ + first || k >= first_edge_ + loop.edges.size()) continue;
      const std::size_t edge = k - first_edge_;
      const double length_mm = edges_[k].length_mm;
      const double nearest_mm = std::clamp(WayTo(edges_[k], begin_mm), 0.0, length_mm);
      for (const double way_mm : {0.0, nearest_mm, length_mm}) {
        const bool is_corner = way_mm <= kOnLine_mm || way_mm >= length_mm - kOnLine_mm;
        if (!is_corner && loop.is_cut[edge] != 0) continue;
        // The first edge ends where the next one begins.
        if (edge == first + 1 && way_mm <= kOnLine_mm) continue;
        const Vec2 place_mm = way_mm <= kOnLine_mm ? edges_[k].begin_mm
                              : is_corner          ? edges_[k].end_mm
                                                   : PointAt(edges_[k], way_mm);
        const double neck_mm = (place_mm - begin_mm).norm();
        if (neck_mm <= neck_mm_ && neck_mm > kOnLine_mm)
          ends_.push_back({edge, way_mm, place_mm});
      }
    }
    std::sort(ends_.begin(), ends_.end(), [](const End& a, const End& b) {
      return std::tie(a.edge, a.way_mm) > std::tie(b.edge, b.way_mm);
    });
  }

  /// A point on the line counts as one on its right, as corners of the run are.
  bool Crosses(const Vec2& begin_mm, const Vec2& end_mm) const {
    const Vec2 along = (end_mm - begin_mm).normalized();
    const double length_mm = (end_mm - begin_mm).norm();
    for (const std::uint32_t k :
         tree_.EdgesIn({begin_mm.cwiseMin(end_mm), begin_mm.cwiseMax(end_mm)})) {
      const Vec2 from = edges_[k].begin_mm - begin_mm, to = edges_[k].end_mm - begin_mm;
      const double from_left = Cross(along, from), to_left = Cross(along, to);
      if ((from_left > kOnLine_mm) == (to_left > kOnLine_mm)) continue;
      const double part = from_left / (from_left - to_left);
      const double way_mm = along.dot(from + part * (to - from));
      if (way_mm > kOnLine_mm && way_mm < length_mm - kOnLine_mm) return true;
    }
    return false;
  }

  Edges edges_;  ///< of all loops
  EdgeTree tree_;
  double neck_mm_;
  double max_mm2_;
  std::size_t first_edge_ = 0;  ///< of the loop that is cut
  std::vector<End> ends_;
};

/// Mirrored about the line x = 0 and against its direction: its area stays to the left.
CutLoop Backwards(const CutLoop& loop) {
  CutLoop turned;
  const auto mirrored = [](const Vec2& place) { return Vec2(-place.x(), place.y()); };
  for (std::size_t k = loop.edges.size(); k-- > 0;) {
    turned.edges.push_back(
        MakeLine(mirrored(loop.edges[k].end_mm), mirrored(loop.edges[k].begin_mm)));
    turned.is_cut.push_back(loop.is_cut[k]);
  }
  return turned;
}

}  // namespace

Region WithoutNarrowBays(const Region& region, double disc_mm, double neck_mm) {
  std::vector<CutLoop> loops;
  for (const Edges& loop : region.loops)
    loops.push_back({loop, std::vector<char>(loop.size(), 0)});
  for (int search = 0; search < 2 && !loops.empty(); ++search) {
    BayCutter cutter(loops, disc_mm, neck_mm);
    std::vector<CutLoop> cut;
    for (const CutLoop& loop : loops) {
      CutLoop next = Backwards(cutter.Cut(loop));
      // Two lines to and fro enclose nothing.
      if (next.edges.size() > 2) cut.push_back(std::move(next));
    }
    loops = std::move(cut);
  }
  Region cut;
  for (CutLoop& loop : loops) cut.loops.push_back(std::move(loop.edges));
  return cut;
}

}  // namespace intaglio::contour
