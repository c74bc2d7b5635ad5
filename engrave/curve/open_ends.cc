#include "engrave/curve/open_ends.h"

#include <cmath>
#include <utility>

namespace intaglio::curve {
namespace {

// More ends than this in one cell cannot be a pair that meets.
constexpr std::size_t kCrowd = 8;

}  // namespace

OpenEnds::OpenEnds(std::vector<std::optional<CurveEnds>> curves, double tolerance_mm)
    : curves_(std::move(curves)), tolerance_mm_(tolerance_mm) {
  neighbours_.assign(2 * curves_.size(), kNoEnd);
  for (End end = 0; end < neighbours_.size(); ++end) {
    if (CanJoin(end)) cells_[CellOf(end)].push_back(end);
  }
  for (End end = 0; end < neighbours_.size(); ++end) {
    if (CanJoin(end)) neighbours_[end] = OnlyNeighbour(end);
  }
}

End OpenEnds::PartnerOf(End end) const {
  const End partner = neighbours_[end];
  return partner != kNoEnd && neighbours_[partner] == end ? partner : kNoEnd;
}

End OpenEnds::FirstOfChain(End end) const {
  End first = end;
  while (PartnerOf(first) != kNoEnd) {
    first = OtherEnd(PartnerOf(first));
    if (first == end) break;
  }
  return first;
}

const Vec3& OpenEnds::PlaceOf(End end) const {
  const CurveEnds& curve = *curves_[end / 2];
  return end % 2 == 0 ? curve.begin_mm : curve.end_mm;
}

OpenEnds::EndCell OpenEnds::CellOf(End end) const {
  const Vec3 p = PlaceOf(end) / tolerance_mm_;
  return {curves_[end / 2]->layer, std::llround(p.x()), std::llround(p.y()),
          std::llround(p.z())};
}

/// The one other end within the tolerance; none when there are more.
End OpenEnds::OnlyNeighbour(End end) const {
  const EndCell middle = CellOf(end);
  End only = kNoEnd;
  for (int step = 0; step < 27; ++step) {
    const EndCell cell{middle[0], middle[1] + step % 3 - 1, middle[2] + step / 3 % 3 - 1,
                       middle[3] + step / 9 - 1};
    const auto found = cells_.find(cell);
    if (found == cells_.end()) continue;
    if (found->second.size() > kCrowd) return kNoEnd;
    for (const End other : found->second) {
      if (other == end || (PlaceOf(other) - PlaceOf(end)).norm() > tolerance_mm_) {
        continue;
      }
      if (only != kNoEnd) return kNoEnd;
      only = other;
    }
  }
  return only;
}

}  // namespace intaglio::curve
