#include "engrave/proof/glass_comparison.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>
#include <numeric>

#include "engrave/core/check.h"

namespace intaglio::proof {
namespace {

struct PointAdaptor {
  const PointList& points;
  std::size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][axis]; }
  template <typename Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<
    nanoflann::L2_Simple_Adaptor<double, PointAdaptor>, PointAdaptor, 3, std::uint32_t>;

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
  const PointAdaptor adaptor{plan_mm};
  const Tree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(16));
  ErrorSums sums;
  for (const std::uint32_t index : by_tick) {
    const Vec3& at = cracks[index].position_mm;
    std::uint32_t point = 0;
    double square = std::numeric_limits<double>::infinity();
    const bool found =
        !plan_mm.empty() && tree.knnSearch(at.data(), 1, &point, &square) == 1;
    if (!found || !(square < match_radius_mm * match_radius_mm)) {
      ++result.stray_count;
      continue;
    }
    if (result.cracks_of_point[point]++ == 0) result.made_order.push_back(point);
    sums.Add(at - plan_mm[point]);
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
  const PointAdaptor adaptor{points_mm};
  const Tree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(16));
  double least = std::numeric_limits<double>::infinity();
  if (points_mm.size() < 2) return least;
  for (const Vec3& p : points_mm) {
    std::uint32_t index[2];
    double square[2];
    tree.knnSearch(p.data(), 2, index, square);
    least = std::min(least, square[1]);  // the nearest one is the point itself
  }
  return std::sqrt(least);
}

}  // namespace intaglio::proof
