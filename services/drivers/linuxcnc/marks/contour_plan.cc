#include "services/drivers/linuxcnc/marks/contour_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <stdexcept>
#include <utility>

#include "engrave/core/try.h"
#include "services/drivers/interface/mark_edges.h"
#include "services/job/plan/course_motion.h"

namespace intaglio::drivers {
namespace {

// Nearer to an end of the way than this the axes rest there.
constexpr double kAtEnd_mm = 1e-3;

/// The setpoints in which the axes go from the begin of the way to its end.
void FindLit(const std::vector<Vec2>& actual_mm, ContourPlan& plan) {
  const auto away_from = [](const Vec2& end_mm) {
    return [&end_mm](const Vec2& at_mm) { return (at_mm - end_mm).norm() > kAtEnd_mm; };
  };
  const auto first = std::ranges::find_if(actual_mm, away_from(actual_mm.front()));
  const auto last =
      std::find_if(actual_mm.rbegin(), actual_mm.rend(), away_from(actual_mm.back()));
  const auto begin = static_cast<std::size_t>(first - actual_mm.begin());
  const auto end = static_cast<std::size_t>(actual_mm.rend() - last);
  plan.lit_begin = begin > 0 ? begin - 1 : 0;
  plan.lit_end = std::min(end + 1, actual_mm.size());
}

}  // namespace

Result<ContourPlan> PlanContour(const mark::Mark& mark, const mark::Pen& pen,
                                const MachineSpec& machine, double period_s,
                                const ProgressSink& progress) {
  const course::AxisPair axes = INTAGLIO_TRY(CourseAxesOf(machine));
  course::PlanOptions options = CourseLimitsOf(machine);
  options.compensate = true;
  options.motor_mm_s2 = options.acceleration_mm_s2;
  options.period_s = period_s;
  // In swings beside a corner the axes are faster than the pen, and than their limits.
  options.swing = false;
  options.executor = [&](std::size_t count,
                         const std::function<void(std::size_t)>& work) {
    for (std::size_t i = 0; i < count; ++i) {
      if (progress && !progress(i, count))
        throw std::runtime_error("the planning of a contour was cancelled");
      work(i);
    }
  };
  const course::Path path =
      INTAGLIO_TRY(CoursePathAlong(EdgesOfMark(mark), pen.speed_mm_s));
  const course::CoursePlan planned =
      INTAGLIO_TRY(course::PlanCourse(path, axes, options));
  if (!planned.holds) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("position_tolerance_um: {:g} um cannot be kept along the "
                            "contour at {:.3f}, {:.3f} mm: {}; raise it, or reduce the "
                            "speed",
                            1e3 * options.tolerance_mm, path.node_mm(0).x(),
                            path.node_mm(0).y(), planned.reason));
  }
  course::Tracked tracked = course::FollowPlan(path, planned, axes, axes);
  ContourPlan plan;
  plan.duration_s = planned.law.duration_s;
  plan.settle_count = course::MemoryInstants(axes, period_s);
  FindLit(tracked.actual_mm, plan);
  plan.setpoints_mm = std::move(tracked.setpoints_mm);
  return plan;
}

}  // namespace intaglio::drivers
