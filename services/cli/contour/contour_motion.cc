#include "services/cli/contour/contour_motion.h"

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/post/tab_parts.h"
#include "services/cli/contour/contour_programs.h"
#include "services/cli/contour/planned_feeds.h"
#include "services/job/plan/course_motion.h"

namespace intaglio::cli {
namespace {

class MotionBuilder {
 public:
  MotionBuilder(const Course& whole, const Vec2& start_mm)
      : whole_(whole), at_mm_(start_mm) {}

  Status TakeMachine(const MachineSpec& machine) {
    auto axes = INTAGLIO_TRY(CourseAxesOf(machine));
    axes_ = std::move(axes);
    limits_ = CourseLimitsOf(machine);
    feed_mm_s_ = std::min(whole_.speed_mm_s(), CourseFeedOf(machine));
    return {};
  }

  void GoTo(const Vec2& place_mm, std::size_t number) {
    if (place_mm == at_mm_) return;
    MotionLeg leg;
    leg.edges = {contour::MakeLine(at_mm_, place_mm)};
    leg.length_mm = leg.edges[0].length_mm;
    leg.duration_s = leg.length_mm / whole_.travel_mm_s();
    Add(std::move(leg), LegKind::kIdle, number);
    at_mm_ = place_mm;
  }

  /// Along z for the time.
  void Stay(double duration_s, LegKind kind, std::size_t number) {
    MotionLeg leg;
    leg.duration_s = duration_s;
    Add(std::move(leg), kind, number);
  }

  Status Work(const post::ToolPath& path, std::size_t number) {
    MotionLeg leg;
    leg.edges = post::EdgesOf(path);
    leg.length_mm = contour::LengthOf(leg.edges);
    leg.duration_s = leg.length_mm / whole_.speed_mm_s();
    if (axes_ && leg.length_mm > 0) {
      const auto planned = INTAGLIO_TRY(CoursePathAlong(leg.edges, feed_mm_s_));
      auto plan = INTAGLIO_TRY(course::PlanCourse(planned, *axes_, limits_));
      if (!plan.holds) ++motion_.not_held;
      leg.duration_s = plan.law.duration_s;
      leg.law = std::move(plan.law);
    }
    motion_.work_s += leg.duration_s;
    Add(std::move(leg), LegKind::kWork, number);
    at_mm_ = path.moves.empty() ? path.begin_mm : path.moves.back().end_mm;
    return {};
  }

  ContourMotion Take() { return std::move(motion_); }

 private:
  void Add(MotionLeg leg, LegKind kind, std::size_t number) {
    leg.kind = kind;
    leg.number = number;
    leg.begin_s = motion_.duration_s;
    leg.begin_mm = at_mm_;
    motion_.duration_s += leg.duration_s;
    motion_.legs.push_back(std::move(leg));
  }

  const Course& whole_;
  Vec2 at_mm_;
  double feed_mm_s_ = 0;
  std::optional<course::AxisPair> axes_;
  course::PlanOptions limits_;
  ContourMotion motion_;
};

Vec2 PlaceAlong(const contour::Edges& edges, double way_mm) {
  for (const contour::Edge& edge : edges) {
    if (way_mm <= edge.length_mm) return contour::PointAt(edge, way_mm);
    way_mm -= edge.length_mm;
  }
  return edges.back().end_mm;
}

}  // namespace

const char* NameOf(LegKind kind) {
  switch (kind) {
    case LegKind::kIdle:
      return "idle";
    case LegKind::kDown:
      return "down";
    case LegKind::kWork:
      return "work";
    case LegKind::kDrill:
      return "drill";
  }
  return "";
}

ToolState ContourMotion::At(double time_s) const {
  const auto next = std::ranges::upper_bound(legs, time_s, {}, &MotionLeg::begin_s);
  ToolState state;
  if (legs.empty()) return state;
  state.leg =
      next == legs.begin() ? 0 : static_cast<std::size_t>(next - legs.begin()) - 1;
  const MotionLeg& leg = legs[state.leg];
  const double since_s = std::clamp(time_s - leg.begin_s, 0.0, leg.duration_s);
  state.place_mm = leg.begin_mm;
  if (leg.edges.empty() || leg.duration_s <= 0) return state;
  state.way_mm = leg.length_mm * since_s / leg.duration_s;
  state.speed_mm_s = leg.length_mm / leg.duration_s;
  if (leg.law) {
    state.way_mm =
        std::clamp(course::SampleLaw(*leg.law, 1, since_s, 1)[0], 0.0, leg.length_mm);
    state.speed_mm_s = course::SampleSpeed(*leg.law, 1, since_s, 1)[0];
  }
  state.place_mm = PlaceAlong(leg.edges, state.way_mm);
  return state;
}

Result<ContourMotion> MotionOf(const ContourWork& work, const Course& whole,
                               const MachineSpec* machine, const Vec2& start_mm) {
  MotionBuilder builder(whole, start_mm);
  if (machine != nullptr) INTAGLIO_TRY(builder.TakeMachine(*machine));
  const bool lifts = !whole.has_power_ratio();
  const post::Cutting cutting = MillingOf(whole, {});
  const double down_s = whole.safe_height_mm() / whole.travel_mm_s() +
                        (whole.safe_height_mm() + whole.depth_mm()) / whole.plunge_mm_s();
  for (std::size_t k = 0; k < work.paths.size(); ++k) {
    for (std::size_t pass = 0; pass < cutting.depths_mm.size(); ++pass) {
      for (const post::PathPart& part : post::PartsOfPass(work.paths[k], cutting, pass)) {
        builder.GoTo(part.path.begin_mm, k);
        if (lifts) builder.Stay(down_s, LegKind::kDown, k);
        INTAGLIO_TRY(builder.Work(part.path, k));
      }
    }
  }
  const double hole_mm = whole.safe_height_mm() + whole.drill_depth_mm();
  const double hole_s = hole_mm * (1 / whole.plunge_mm_s() + 1 / whole.travel_mm_s());
  for (std::size_t k = 0; k < work.rounds.size(); ++k) {
    for (const Vec2& place_mm : work.rounds[k].places_mm) {
      builder.GoTo(place_mm, k);
      builder.Stay(hole_s, LegKind::kDrill, k);
    }
  }
  return builder.Take();
}

}  // namespace intaglio::cli
