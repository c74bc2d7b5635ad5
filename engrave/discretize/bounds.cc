#include "engrave/discretize/bounds.h"

#include <fmt/format.h>

#include <algorithm>

namespace intaglio::discretize {
namespace {
constexpr const char* kSides[6] = {"low x",  "high x", "low y",
                                   "high y", "low z",  "high z"};
}  // namespace

BoundsReport CheckBounds(const PointList& points_mm, const Box3& permitted_mm) {
  BoundsReport report;
  for (const Vec3& p : points_mm) {
    if (permitted_mm.Contains(p)) continue;
    ++report.outside_count;
    for (int axis = 0; axis < 3; ++axis) {
      const double excess[2] = {permitted_mm.min_mm[axis] - p[axis],
                                p[axis] - permitted_mm.max_mm[axis]};
      for (int end = 0; end < 2; ++end) {
        const std::size_t side = static_cast<std::size_t>(2 * axis + end);
        if (!(excess[end] > 0)) continue;
        ++report.side_count[side];
        report.side_excess_mm[side] = std::max(report.side_excess_mm[side], excess[end]);
      }
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
    if (permitted_mm.Contains(cloud.points_mm[i]))
      kept.Add(cloud.points_mm[i], cloud.source[i]);
  }
  return kept;
}

}  // namespace intaglio::discretize
