#include "engrave/proof/glass_comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "engrave/core/check.h"
#include "engrave/proof/point_tree.h"

namespace intaglio::proof {
namespace {

constexpr double kUmPerMm = 1000;

// Sums over the matched cracks, in mm^2 until the end.
struct ErrorSums {
  Vec3 squares = Vec3::Zero();
  double max_square = 0;
  std::uint64_t count = 0;

  void Add(const Vec3& error_mm) {
    squares += error_mm.cwiseAbs2();
    max_square = std::max(max_square, error_mm.squaredNorm());
    ++count;
  }
  AxisErrors Finish() const {
    if (count == 0) return {};
    const double n = static_cast<double>(count);
    return {std::sqrt(squares.sum() / n) * kUmPerMm, std::sqrt(max_square) * kUmPerMm,
            (squares / n).cwiseSqrt() * kUmPerMm};
  }
};

}  // namespace

GlassComparison CompareGlass(const PointList& plan_mm, const std::vector<Crack>& cracks,
                             double match_radius_mm) {
  Require(match_radius_mm > 0, "match_radius_mm must be positive, is {}",
          match_radius_mm);
  GlassComparison result;
  result.planned_count = plan_mm.size();
  result.cracks_of_point.assign(plan_mm.size(), 0);
  std::vector<std::uint32_t> by_tick(cracks.size());
  std::iota(by_tick.begin(), by_tick.end(), 0);
  std::stable_sort(by_tick.begin(), by_tick.end(), [&](std::uint32_t a, std::uint32_t b) {
    return cracks[a].tick < cracks[b].tick;
  });
  if (!by_tick.empty()) {
    result.first_tick = cracks[by_tick.front()].tick;
    result.last_tick = cracks[by_tick.back()].tick;
  }
  const PointTree tree(plan_mm);
  ErrorSums sums;
  for (const std::uint32_t index : by_tick) {
    const Vec3& at = cracks[index].position_mm;
    PointTree::Neighbour nearest;
    if (!plan_mm.empty()) nearest = tree.Nearest(at);
    if (!(nearest.square < match_radius_mm * match_radius_mm)) {
      ++result.stray_count;
      continue;
    }
    if (result.cracks_of_point[nearest.index]++ == 0) {
      result.made_order.push_back(nearest.index);
    }
    sums.Add(at - plan_mm[nearest.index]);
  }
  for (const std::uint32_t count : result.cracks_of_point) {
    ++(count == 0   ? result.empty_count
       : count == 1 ? result.made_count
                    : result.doubled_count);
  }
  result.errors = sums.Finish();
  return result;
}

double LeastSpacing(const PointList& points_mm) {
  const PointTree tree(points_mm);
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t i = 0; i < points_mm.size(); ++i) {
    least = std::min(least, tree.NearestOther(i).square);
  }
  return std::sqrt(least);
}

}  // namespace intaglio::proof
