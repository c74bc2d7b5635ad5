#include "tests/integration/point_difference.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <vector>

namespace intaglio::testing {
namespace {

struct Nearest {
  std::size_t point = 0;
  double away_mm = std::numeric_limits<double>::infinity();
};

/// Looks at all points, or at those alone that are not made yet.
Nearest FindNearest(const PointList& points_mm, const Vec3& at_mm,
                    const std::vector<bool>& is_made, bool of_all) {
  Nearest nearest;
  for (std::size_t i = 0; i < points_mm.size(); ++i) {
    const double away_mm = (points_mm[i] - at_mm).norm();
    if (away_mm < nearest.away_mm && (of_all || !is_made[i])) nearest = {i, away_mm};
  }
  return nearest;
}

}  // namespace

std::string PointDifference(const PointList& points_mm, const PointList& made_mm,
                            double tolerance_mm) {
  std::vector<bool> is_made(points_mm.size(), false);
  std::string text;
  for (std::size_t i = 0; i < made_mm.size(); ++i) {
    const Nearest open = FindNearest(points_mm, made_mm[i], is_made, false);
    if (open.away_mm <= tolerance_mm) {
      is_made[open.point] = true;
      continue;
    }
    const Nearest any = FindNearest(points_mm, made_mm[i], is_made, true);
    text += any.away_mm <= tolerance_mm
                ? fmt::format("point {} is made again by {}\n", any.point, i)
                : fmt::format("{} is {:.3f} mm from any point\n", i, any.away_mm);
  }
  if (const auto missing = std::ranges::count(is_made, false); missing > 0)
    text += fmt::format("{} points are missing\n", missing);
  return text;
}

}  // namespace intaglio::testing
