#pragma once

// Which ends of open curves meet: an end is joined to another one when each of the two is
// the only end of its layer near the other. CAD programs write an outline as single lines
// and arcs.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/curve/cell.h"

namespace intaglio::curve {

/// End 2 i is the beginning of curve i, end 2 i + 1 its end.
using End = std::size_t;
inline constexpr End kNoEnd = static_cast<End>(-1);

inline End OtherEnd(End end) { return end ^ 1; }

/// Where a curve begins and ends, mm.
struct CurveEnds {
  std::int64_t layer = 0;
  Vec3 begin_mm = Vec3::Zero();
  Vec3 end_mm = Vec3::Zero();
};

class OpenEnds {
 public:
  /// One entry for each curve; nothing of one that cannot be joined, as a closed one.
  /// Ends meet when they are no farther apart than `tolerance_mm` > 0. Where many ends
  /// crowd none do.
  OpenEnds(std::vector<std::optional<CurveEnds>> curves, double tolerance_mm);

  /// The end that `end` is joined to, or kNoEnd.
  End PartnerOf(End end) const;

  /// From `end` backwards over its curve's partners until nothing is joined; round a ring
  /// to `end` again.
  End FirstOfChain(End end) const;

 private:
  using EndCell = Cell<4>;  // layer, then place

  bool CanJoin(End end) const { return curves_[end / 2].has_value(); }
  const Vec3& PlaceOf(End end) const;
  EndCell CellOf(End end) const;
  End OnlyNeighbour(End end) const;

  std::vector<std::optional<CurveEnds>> curves_;
  double tolerance_mm_;
  std::unordered_map<EndCell, std::vector<End>, CellHash> cells_;
  std::vector<End> neighbours_;
};

}  // namespace intaglio::curve
