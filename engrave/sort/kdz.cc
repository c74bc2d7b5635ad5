// Why the greedy never fires through an earlier crack. Let c(a, b) be the cost of going
// from a to b, and m(a, b) = max(|dx|, |dy|). Say e was made before p although e lies
// strictly inside the cone above p: with h = e.z - p.z > 0, hypot(dx, dy) < t h, t the
// cone's tangent (of a cone with cracks its steepest one, beam_cone.h). When e was
// chosen, from a, p remained, and
//   c(a, p) = m(a, p) + K (p.z - a.z)
//           <= m(a, e) + m(e, p) + K (e.z - a.z) - K h       (m is a metric)
//           = c(a, e) + m(e, p) - K h < c(a, e),
// since m(e, p) <= hypot(dx, dy) < t h <= K h. So p was cheaper: a contradiction. The
// first point is the lowest and is not shaded by any other.
//
// K z_now is the same for all candidates and is left out: the cost compared is
// m + K z_next, each product rounded once.

#include "engrave/sort/kdz.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "engrave/core/check.h"
#include "engrave/sort/beam/lowest_point.h"
#include "engrave/sort/beam/remaining_points.h"

namespace intaglio::sort {
namespace {

constexpr double kMinMovingRatio = 0.6;
constexpr double kMaxUpRatio = 100;
constexpr std::size_t kPointsPerKdzReport = 1 << 16;

}  // namespace

double DefaultUpRatio(const BeamCone& cone) {
  RequireUsable(cone);
  return std::max(kMinMovingRatio, cone.SteepestTangent());
}

Status CheckKdzOptions(const OrderOptions& options) {
  const double up_ratio = options.kdz.up_ratio;
  if (up_ratio >= 0 && up_ratio <= kMaxUpRatio) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("kdz.up_ratio: {} is outside 0..{}", up_ratio, kMaxUpRatio),
              fmt::format("{}", up_ratio));
}

Result<Order> OrderByKdz(const PointList& points_mm, const OrderOptions& options,
                         const ProgressSink& progress) {
  Order order(points_mm.size());
  if (points_mm.empty()) return order;
  std::iota(order.begin(), order.end(), 0U);
  RemainingPoints remaining(points_mm, order, options.kdz.up_ratio);
  // From above the lowest point itself nothing is nearer than it.
  const Vec3& lowest_mm = points_mm[LowestPoint(points_mm)];
  RemainingPoints::Taken now{0, lowest_mm.x(), lowest_mm.y()};
  for (std::size_t made = 0; made < order.size(); ++made) {
    if (progress && made % kPointsPerKdzReport == 0 && !progress(made, order.size())) {
      return Fail(ErrorCode::kCancelled, "the sort was cancelled");
    }
    now = remaining.TakeNearest(now.x_mm, now.y_mm);
    order[made] = now.index;
  }
  return order;
}

}  // namespace intaglio::sort
