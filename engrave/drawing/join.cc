#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "engrave/core/check.h"
#include "engrave/drawing/cell.h"
#include "engrave/drawing/flatten.h"

namespace intaglio::drawing {
namespace {

/// End 2 i is the beginning of curve i, end 2 i + 1 its end.
using End = std::size_t;
constexpr End kNoEnd = static_cast<End>(-1);
// More ends than this in one cell cannot be a pair that meets.
constexpr std::size_t kCrowd = 8;

End OtherEnd(End end) { return end ^ 1; }

using EndCell = Cell<4>;  // layer, then place

class Joiner {
 public:
  Joiner(double tolerance_mm, std::vector<FlatCurve> curves)
      : tolerance_mm_(tolerance_mm), curves_(std::move(curves)) {}

  std::vector<FlatCurve> Join() {
    for (End end = 0; end < 2 * curves_.size(); ++end) {
      if (CanJoin(end)) cells_[CellOf(end)].push_back(end);
    }
    partner_.assign(2 * curves_.size(), kNoEnd);
    for (End end = 0; end < partner_.size(); ++end) {
      if (CanJoin(end)) partner_[end] = OnlyNeighbour(end);
    }
    used_.assign(curves_.size(), false);
    std::vector<FlatCurve> joined;
    for (std::size_t i = 0; i < curves_.size(); ++i) {
      if (!used_[i]) joined.push_back(Chain(FirstEndOfChain(2 * i)));
    }
    return joined;
  }

 private:
  bool CanJoin(End end) const {
    return !curves_[end / 2].closed && curves_[end / 2].points_mm.size() > 1;
  }
  const Vec3& PointOf(End end) const {
    const PointList& points = curves_[end / 2].points_mm;
    return end % 2 == 0 ? points.front() : points.back();
  }
  EndCell CellOf(End end) const {
    const Vec3 p = PointOf(end) / tolerance_mm_;
    return {curves_[end / 2].layer, std::llround(p.x()), std::llround(p.y()),
            std::llround(p.z())};
  }

  /// The one other end within the tolerance; none when there are more.
  End OnlyNeighbour(End end) const {
    const EndCell middle = CellOf(end);
    End only = kNoEnd;
    for (int step = 0; step < 27; ++step) {
      const EndCell cell{middle[0], middle[1] + step % 3 - 1,
                         middle[2] + step / 3 % 3 - 1, middle[3] + step / 9 - 1};
      const auto found = cells_.find(cell);
      if (found == cells_.end()) continue;
      if (found->second.size() > kCrowd) return kNoEnd;
      for (const End other : found->second) {
        if (other == end || (PointOf(other) - PointOf(end)).norm() > tolerance_mm_) {
          continue;
        }
        if (only != kNoEnd) return kNoEnd;
        only = other;
      }
    }
    return only;
  }

  /// The end that `end` is joined to: each is the only neighbour of the other.
  End Partner(End end) const {
    const End partner = partner_[end];
    return partner != kNoEnd && partner_[partner] == end ? partner : kNoEnd;
  }

  /// Backwards from `end` until nothing is joined, or round a ring to `end` again.
  End FirstEndOfChain(End end) const {
    End first = end;
    while (Partner(first) != kNoEnd) {
      first = OtherEnd(Partner(first));
      if (first == end) break;
    }
    return first;
  }

  FlatCurve Chain(End first) {
    const FlatCurve& head = curves_[first / 2];
    if (Partner(first) == kNoEnd && Partner(OtherEnd(first)) == kNoEnd) {
      used_[first / 2] = true;
      return std::move(curves_[first / 2]);
    }
    FlatCurve chain{{}, false, head.layer, head.color};
    PointList& points = chain.points_mm;
    End end = first;
    while (true) {
      used_[end / 2] = true;
      PointList part = std::move(curves_[end / 2].points_mm);
      const auto skip = points.empty() ? 0 : 1;  // the point of the joint is already in
                                                 // the list
      if (end % 2 == 0) {
        points.insert(points.end(), part.begin() + skip, part.end());
      } else {
        points.insert(points.end(), part.rbegin() + skip, part.rend());
      }
      const End next = Partner(OtherEnd(end));
      if (next == kNoEnd) return chain;
      if (next == first) break;
      end = next;
    }
    if (points.size() > 3) {
      points.pop_back();
      chain.closed = true;
    }
    return chain;
  }

  double tolerance_mm_;
  std::vector<FlatCurve> curves_;
  std::unordered_map<EndCell, std::vector<End>, CellHash> cells_;
  std::vector<End> partner_;
  std::vector<bool> used_;
};

}  // namespace

void JoinOpenCurves(double tolerance_mm, FlatDrawing& flat) {
  Require(tolerance_mm >= 1e-6 && tolerance_mm <= 10,
          "tolerance_mm of joining must be 1e-6 .. 10, is {}", tolerance_mm);
  flat.curves = Joiner(tolerance_mm, std::move(flat.curves)).Join();
}

}  // namespace intaglio::drawing
