#include "engrave/discretize/spacing/bounds.h"

#include <fmt/format.h>

#include <algorithm>

#include "engrave/core/check.h"
#include "engrave/core/counted.h"

namespace intaglio::discretize {
namespace {

/// How far outside of a side; 0 within the tolerance. Sides as in BoundsReport.
double ExcessMm(const Vec3& p_mm, const Box3& permitted_mm, std::size_t side) {
  const auto axis = static_cast<Eigen::Index>(side / 2);
  const double excess_mm = side % 2 == 0 ? permitted_mm.min_mm[axis] - p_mm[axis]
                                         : p_mm[axis] - permitted_mm.max_mm[axis];
  return excess_mm <= kBoundsToleranceMm ? 0 : excess_mm;
}

/// Whether the point is inside; if not it is counted.
bool IsInside(const Vec3& p_mm, const Box3& permitted_mm, BoundsReport& report) {
  bool inside = true;
  for (std::size_t side = 0; side < 6; ++side) {
    const double excess_mm = ExcessMm(p_mm, permitted_mm, side);
    if (excess_mm == 0) continue;
    inside = false;
    ++report.side_count[side];
    report.side_excess_mm[side] = std::max(report.side_excess_mm[side], excess_mm);
  }
  if (!inside) ++report.outside_count;
  return inside;
}

constexpr const char* kSides[6] = {"low x",  "high x", "low y",
                                   "high y", "low z",  "high z"};
}  // namespace

void BoundsReport::Add(const BoundsReport& other) {
  outside_count += other.outside_count;
  for (std::size_t side = 0; side < 6; ++side) {
    side_count[side] += other.side_count[side];
    side_excess_mm[side] = std::max(side_excess_mm[side], other.side_excess_mm[side]);
  }
}

namespace {

template <typename BoxOf>
BoundsReport TakeOutsideOf(const BoxOf& permitted_mm, SpacedCloud& cloud) {
  BoundsReport report;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!IsInside(cloud.points_mm[i], permitted_mm(cloud.source[i]), report)) continue;
    cloud.points_mm[kept] = cloud.points_mm[i];
    cloud.source[kept] = cloud.source[i];
    cloud.spacing_mm[kept] = cloud.spacing_mm[i];
    ++kept;
  }
  cloud.Resize(kept);
  return report;
}

}  // namespace

BoundsReport TakeOutside(const Box3& permitted_mm, SpacedCloud& cloud) {
  return TakeOutsideOf([&](std::uint32_t) -> const Box3& { return permitted_mm; }, cloud);
}

BoundsReport TakeOutside(std::span<const Box3> permitted_of_source_mm,
                         SpacedCloud& cloud) {
  for (const std::uint32_t source : cloud.source) {
    Require(source < permitted_of_source_mm.size(), "source {} of {} boxes", source,
            permitted_of_source_mm.size());
  }
  return TakeOutsideOf(
      [&](std::uint32_t source) -> const Box3& { return permitted_of_source_mm[source]; },
      cloud);
}

Error OutsideBlock(const BoundsReport& report, std::uint64_t point_count) {
  std::string sides;
  for (std::size_t i = 0; i < 6; ++i) {
    if (report.side_count[i] == 0) continue;
    sides += fmt::format("{}{} beyond the {} side by up to {:.3f} mm",
                         sides.empty() ? "" : ", ", report.side_count[i], kSides[i],
                         report.side_excess_mm[i]);
  }
  return {ErrorCode::kOutsideBlock,
          fmt::format("{} of {} {} outside the block minus its margin: {}; scale "
                      "or move the model, use a larger block, or set block.clip",
                      report.outside_count, Counted(point_count, "point"),
                      VerbFor(report.outside_count, "lies", "lie"), sides),
          fmt::format("{}", report.outside_count)};
}

}  // namespace intaglio::discretize
