#include "engrave/discretize/bounds.h"

#include <fmt/format.h>

#include <algorithm>

namespace intaglio::discretize {
namespace {

/// How far outside of a side; 0 within the tolerance. Sides as in BoundsReport.
double ExcessMm(const Vec3& p_mm, const Box3& permitted_mm, std::size_t side) {
  const auto axis = static_cast<Eigen::Index>(side / 2);
  const double excess_mm = side % 2 == 0 ? permitted_mm.min_mm[axis] - p_mm[axis]
                                         : p_mm[axis] - permitted_mm.max_mm[axis];
  return excess_mm <= kBoundsToleranceMm ? 0 : excess_mm;
}

bool IsInside(const Vec3& p_mm, const Box3& permitted_mm) {
  for (std::size_t side = 0; side < 6; ++side) {
    if (ExcessMm(p_mm, permitted_mm, side) != 0) return false;
  }
  return true;
}

constexpr const char* kSides[6] = {"low x",  "high x", "low y",
                                   "high y", "low z",  "high z"};
}  // namespace

BoundsReport CheckBounds(const PointList& points_mm, const Box3& permitted_mm) {
  BoundsReport report;
  for (const Vec3& p : points_mm) {
    if (IsInside(p, permitted_mm)) continue;
    ++report.outside_count;
    for (std::size_t side = 0; side < 6; ++side) {
      const double excess_mm = ExcessMm(p, permitted_mm, side);
      if (excess_mm == 0) continue;
      ++report.side_count[side];
      report.side_excess_mm[side] = std::max(report.side_excess_mm[side], excess_mm);
    }
  }
  return report;
}

Result<PointCloud> KeepInside(PointCloud cloud, const Box3& permitted_mm, bool clip) {
  const BoundsReport report = CheckBounds(cloud.points_mm, permitted_mm);
  if (report.outside_count == 0) return cloud;
  if (!clip) {
    std::string sides;
    for (std::size_t i = 0; i < 6; ++i) {
      if (report.side_count[i] == 0) continue;
      sides += fmt::format("{}{} beyond the {} side by up to {:.3f} mm",
                           sides.empty() ? "" : ", ", report.side_count[i], kSides[i],
                           report.side_excess_mm[i]);
    }
    return Fail(
        ErrorCode::kOutsideBlock,
        fmt::format("{} of {} points lie outside the block minus its margin: {}; scale "
                    "or move the model, take a larger block, or set block.clip",
                    report.outside_count, cloud.size(), sides),
        fmt::format("{}", report.outside_count));
  }
  PointCloud kept;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (IsInside(cloud.points_mm[i], permitted_mm))
      kept.Add(cloud.points_mm[i], cloud.source[i]);
  }
  return kept;
}

}  // namespace intaglio::discretize
