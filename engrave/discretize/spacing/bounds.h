#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/discretize/spacing/spaced_cloud.h"

namespace intaglio::discretize {

/// A point outside by no more than this counts as inside: a model fitted into the block
/// touches the limits, and rounding moves some of its points beyond them.
inline constexpr double kBoundsToleranceMm = 1e-6;

/// Points outside a box, glass frame, mm.
struct BoundsReport {
  std::uint64_t outside_count = 0;
  /// By side: below x, above x, below y, above y, below z, above z.
  std::array<std::uint64_t, 6> side_count{};
  std::array<double, 6> side_excess_mm{};  ///< the farthest of each

  void Add(const BoundsReport& other);
};

/// Removes the points outside the box from the cloud, and reports them.
BoundsReport TakeOutside(const Box3& permitted_mm, SpacedCloud& cloud);
/// The same with a box for each source.
BoundsReport TakeOutside(std::span<const Box3> permitted_of_source_mm,
                         SpacedCloud& cloud);

/// kOutsideBlock: how many of the points, on which sides and by how much.
Error OutsideBlock(const BoundsReport& report, std::uint64_t point_count);

}  // namespace intaglio::discretize
