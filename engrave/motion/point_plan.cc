#include "engrave/motion/point_plan.h"

#include <utility>

#include "engrave/core/check.h"

namespace intaglio::motion {

PointPlan::PointPlan(const PlanOptions& options, const Vec3& start_mm, Sink sink)
    : options_(options),
      sink_(std::move(sink)),
      last_mm_(start_mm),
      planner_(MakePlanner(options, start_mm)) {}

void PointPlan::Append(const Vec3& point_mm) {
  if (!planner_) planner_ = MakePlanner(options_, last_mm_);
  planner_->Append(point_mm, next_point_++, true, segments_);
  last_mm_ = point_mm;
  PassOn();
}

void PointPlan::Rest() {
  if (!planner_) return;
  planner_->Finish(segments_);
  PassOn();
  moves_.Add(planner_->moves());
  planner_.reset();
}

void PointPlan::PassOn() {
  if (!segments_.empty()) sink_(segments_);
  segments_.clear();
}

std::vector<Segment> PlanPoints(const PlanOptions& options,
                                std::span<const Vec3> points_mm) {
  Require(!points_mm.empty(), "there is no point");
  std::vector<Segment> all;
  PointPlan plan(options, points_mm.front(), [&all](std::span<const Segment> segments) {
    all.insert(all.end(), segments.begin(), segments.end());
  });
  for (const Vec3& point_mm : points_mm) plan.Append(point_mm);
  plan.Rest();
  return all;
}

}  // namespace intaglio::motion
