#include "services/client/teach/job_outline.h"

#include <utility>

#include "engrave/core/convex_hull.h"
#include "engrave/core/try.h"
#include "services/drivers/interface/hand_motion.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio::client {
namespace {

constexpr double kArcTolerance_mm = 0.01;

}  // namespace

Result<std::vector<Vec2>> OutlineOfJob(const FrozenJob& job, const PointCloud& cloud) {
  const std::vector<machine::AxesFromGlass> by_model = AxesFromGlassOfModels(job);
  const Box3 travel = AxisLimitsOf(job.machine()).travel_mm;
  Vec3 near = (travel.min_mm + travel.max_mm) / 2;
  std::vector<Vec2> places;
  places.reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto& axes_from_glass = by_model.at(cloud.source[i]);
    near = INTAGLIO_TRY(axes_from_glass.ToAxes(cloud.points_mm[i], near));
    places.emplace_back(near.head<2>());
  }
  return WithFewerCorners(ConvexHull(std::move(places)), drivers::kMaxOutlineCorners);
}

Result<std::vector<Vec2>> OutlineOfMarks(const mark::MarkSet& set) {
  std::vector<Vec2> places;
  for (const mark::Mark& mark : set.marks) {
    if (mark.web_mm != 0) {
      return Fail(ErrorCode::kUnsupported,
                  "marks on a web have no place in the field before the web runs: there "
                  "is no outline of them");
    }
    for (const Vec2& place : mark::PlacesOf(mark, kArcTolerance_mm))
      places.push_back(place);
  }
  return WithFewerCorners(ConvexHull(std::move(places)), drivers::kMaxOutlineCorners);
}

std::vector<Vec2> RectangleAround(const std::vector<Vec2>& corners_mm) {
  Vec2 low = corners_mm.front(), high = low;
  for (const Vec2& corner : corners_mm) {
    low = low.cwiseMin(corner);
    high = high.cwiseMax(corner);
  }
  return {low, Vec2(high.x(), low.y()), high, Vec2(low.x(), high.y())};
}

}  // namespace intaglio::client
