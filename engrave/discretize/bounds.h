#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::discretize {

/// A point this little outside is inside: a model fitted into the block touches the
/// limits, and rounding puts points of it beyond them.
inline constexpr double kBoundsToleranceMm = 1e-6;

/// Points outside a box, glass frame, mm.
struct BoundsReport {
  std::uint64_t outside_count = 0;
  /// By side: below x, above x, below y, above y, below z, above z.
  std::array<std::uint64_t, 6> side_count{};
  std::array<double, 6> side_excess_mm{};  ///< the farthest of each
};

BoundsReport CheckBounds(const PointList& points_mm, const Box3& permitted_mm);

/// The points that lie in the block minus its margin. If any do not: kOutsideBlock with
/// how many, on which sides and by how much, unless `clip` drops them.
Result<PointCloud> KeepInside(PointCloud cloud, const Box3& permitted_mm, bool clip);

}  // namespace intaglio::discretize
