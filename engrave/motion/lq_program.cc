#include "engrave/motion/lq_program.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/motion/axis/lq.h"
#include "engrave/motion/axis/profile.h"

// Time is counted in stages and the way is 1, so that the matrices are of the order of 1
// whatever the step: the state is (x - 1, v) from (-1, 0) to 0, the weight of the speed
// (w T / N)^2.

namespace intaglio::motion {
namespace {

/// Powers of two, so that a stage is whole subticks. The maximum keeps stages below
/// kMaxSegmentTicks in a step of kMaxStepTicks.
constexpr std::uint64_t kFewestStages = 8;
constexpr std::uint64_t kMaxStages = 512;
static_assert(kMaxStepTicks / kMaxStages <= kMaxSegmentTicks);

/// Where the step is at the end of each stage: share of the way done, per stage.
struct StageCourse {
  std::uint64_t ticks = 0;
  std::vector<Eigen::Vector2d> states;
  double peak_per_stage = 0.0;
  double peak_per_stage2 = 0.0;

  double StageSeconds(double rate_hz) const {
    return static_cast<double>(ticks) / rate_hz / static_cast<double>(states.size());
  }
};

/// Half of the time constant 1 / w is resolved.
std::uint64_t StagesFor(double duration_w) {
  std::uint64_t stages = kFewestStages;
  while (stages < kMaxStages && static_cast<double>(stages) < 2.0 * duration_w) {
    stages *= 2;
  }
  return stages;
}

StageCourse CourseOver(std::uint64_t ticks, double rate_hz, double w_per_s) {
  const double duration_w = w_per_s * static_cast<double>(ticks) / rate_hz;
  const std::uint64_t stages =
      std::max(StagesFor(duration_w), ticks > kMaxSegmentTicks ? kMaxStages : 0);
  const double stage_w = duration_w / static_cast<double>(stages);
  const LqRecursion recursion(
      AxisStage({}, {.position = 0.0, .speed = stage_w * stage_w, .control = 1.0}, 1.0),
      stages, Eigen::Matrix2d::Zero());
  StageCourse course{.ticks = ticks, .states = {}};
  course.states.reserve(stages);
  Eigen::Vector2d state(-1.0, 0.0);
  for (std::uint64_t j = 0; j < stages; ++j) {
    const double control = recursion.ControlAt(j, state);
    state = recursion.Next(state, control);
    course.states.push_back(state);
    course.peak_per_stage = std::max(course.peak_per_stage, std::abs(state.y()));
    course.peak_per_stage2 = std::max(course.peak_per_stage2, std::abs(control));
  }
  return course;
}

bool Fits(const StageCourse& course, double rate_hz, const AxisLimits& unit) {
  const double stage_s = course.StageSeconds(rate_hz);
  const double slack = 1.0 + kTickSlackRatio;
  return course.peak_per_stage <= slack * unit.max_speed_mm_s * stage_s &&
         course.peak_per_stage2 <=
             slack * unit.max_acceleration_mm_s2 * stage_s * stage_s;
}

/// The fewest ticks that keep the limits: from the minimum time of all courses upwards by
/// doubling, then by bisection.
StageCourse ShortestCourse(double rate_hz, const AxisLimits& unit, double w_per_s) {
  std::uint64_t tried = WholeTicks(StopAndGoSeconds(1.0, unit), rate_hz);
  std::uint64_t below = tried - 1;
  StageCourse course;
  while (true) {
    Require(tried <= kMaxStepTicks, "a step takes over {} ticks", kMaxStepTicks);
    course = CourseOver(tried, rate_hz, w_per_s);
    if (Fits(course, rate_hz, unit)) break;
    below = tried;
    tried = 2 * below;
  }
  while (course.ticks - below > 1) {
    StageCourse shorter =
        CourseOver(below + (course.ticks - below) / 2, rate_hz, w_per_s);
    if (Fits(shorter, rate_hz, unit)) {
      course = std::move(shorter);
    } else {
      below = shorter.ticks;
    }
  }
  return course;
}

}  // namespace

std::uint64_t LqProgram::Append(const Vec3& from_mm, const Vec3& to_mm,
                                std::vector<Segment>& out) const {
  const Vec3 step_mm = to_mm - from_mm;
  const AxisLimits unit = UnitStepLimits(step_mm, limits_);
  const double w_per_s =
      rate_per_s_.value_or(unit.max_acceleration_mm_s2 / unit.max_speed_mm_s);
  const StageCourse course = ShortestCourse(rate_hz_, unit, w_per_s);
  const double stage_s = course.StageSeconds(rate_hz_);
  const std::uint64_t stage_subticks =
      course.ticks * kSubticksPerTick / course.states.size();
  for (const Eigen::Vector2d& state : course.states) {
    Segment segment;
    segment.end_position_mm = to_mm + state.x() * step_mm;
    segment.end_velocity_mm_s = state.y() / stage_s * step_mm;
    segment.duration_subticks = static_cast<std::uint32_t>(stage_subticks);
    out.push_back(segment);
  }
  EndAtRest(to_mm, out.back());
  return course.ticks;
}

}  // namespace intaglio::motion
