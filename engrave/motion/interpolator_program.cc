#include "engrave/motion/interpolator_program.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/motion/axis/interpolator.h"

// A course over the length l with ramps of r and a cruise of c grid lengths g has
//   V = l / ((r + c) g),   A = V / (r g).
// With l / V0 and V0 / a0 the times of the limits,
//   long way, sqrt(l a0) > V0:   r + c = ceil(l / (V0 g)),   r = ceil(V0 / (a0 g))
//   short way:                   r = ceil(sqrt(l / a0) / g), c = 0
// keep both limits: V <= V0, and A = V / (r g) <= V0 / (r g) <= a0 in the first case,
// A = l / (r g)^2 <= a0 in the second. r <= r + c, as l / V0 > V0 / a0.

namespace intaglio::motion {
namespace {

/// A course from 0 to 1 of the whole way, times in subticks.
class GridCourse {
 public:
  GridCourse(double length_mm, const AxisLimits& limits, double rate_hz)
      : rate_hz_(rate_hz) {
    if (length_mm == 0.0) return;
    const double grid_s = DurationSeconds(kGridSubticks, rate_hz);
    const TimeOptimalChoice choice = ChooseTimeOptimal(length_mm, limits);
    const double longest = static_cast<double>(kMaxStepTicks * kSubticksPerTick);
    Require(choice.seconds / grid_s * kGridSubticks < longest,
            "a step of {} mm takes {} s, more than {} ticks", length_mm, choice.seconds,
            kMaxStepTicks);
    const auto grid_lengths = [grid_s](double seconds) {
      // The tolerance of WholeTicks: an excess by rounding does not add a grid length.
      return std::max<std::uint64_t>(1, static_cast<std::uint64_t>(std::ceil(
                                            seconds / grid_s * (1.0 - kTickSlackRatio))));
    };
    const std::uint64_t ramp =
        grid_lengths(choice.speed_mm_s / choice.acceleration_mm_s2);
    const std::uint64_t ramp_and_cruise =
        std::max(ramp, grid_lengths(length_mm / choice.speed_mm_s));
    first_ = ramp * kGridSubticks;
    second_ = ramp_and_cruise * kGridSubticks;
    const double speed_per_s = 1.0 / DurationSeconds(second_, rate_hz);
    course_ = Interpolator(0.0, 1.0,
                           {speed_per_s, speed_per_s / DurationSeconds(first_, rate_hz)});
  }

  std::uint64_t first_switch() const { return first_; }
  std::uint64_t second_switch() const { return second_; }
  std::uint64_t end() const { return first_ + second_; }

  AxisState At(std::uint64_t subticks) const {
    if (subticks >= end()) return {1.0, 0.0, 0.0};
    return course_.At(DurationSeconds(subticks, rate_hz_));
  }

 private:
  double rate_hz_;
  std::uint64_t first_ = 0;
  std::uint64_t second_ = 0;
  Interpolator course_{0.0, 0.0, {}};
};

/// The step whose axis i follows courses[i]; with the wait for the tick.
std::uint64_t AppendCourses(const std::array<const GridCourse*, 3>& courses,
                            const Vec3& from_mm, const Vec3& to_mm,
                            std::vector<Segment>& out) {
  std::array<std::uint64_t, 10> knots{};
  std::uint64_t end = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    knots[3 * axis] = courses[axis]->first_switch();
    knots[3 * axis + 1] = courses[axis]->second_switch();
    knots[3 * axis + 2] = courses[axis]->end();
    end = std::max(end, courses[axis]->end());
  }
  const std::uint64_t ticks = (end + kSubticksPerTick - 1) / kSubticksPerTick;
  knots[9] = ticks * kSubticksPerTick;
  std::ranges::sort(knots);
  const Vec3 step_mm = to_mm - from_mm;
  AppendThroughKnots(
      knots,
      [&](std::uint64_t at) {
        KnotState state{to_mm, Vec3::Zero()};
        for (int axis = 0; axis < 3; ++axis) {
          const GridCourse& course = *courses[static_cast<std::size_t>(axis)];
          if (at >= course.end()) continue;
          const AxisState done = course.At(at);
          state.position_mm[axis] = from_mm[axis] + done.position_mm * step_mm[axis];
          state.velocity_mm_s[axis] = done.speed_mm_s * step_mm[axis];
        }
        return state;
      },
      out);
  return ticks;
}

/// `largest` of the axes that move, lowered so that their vector is no longer than
/// `longest`.
Vec3 Shared(const Vec3& largest, const Vec3& way_mm, double longest) {
  const Vec3 moving = (way_mm.array() > 0.0).select(largest, 0.0);
  return std::min(1.0, longest / moving.norm()) * largest;
}

}  // namespace

std::uint64_t TimeOptimalProgram::Append(const Vec3& from_mm, const Vec3& to_mm,
                                         std::vector<Segment>& out) const {
  const GridCourse course(1.0, UnitStepLimits(to_mm - from_mm, limits_), rate_hz_);
  return AppendCourses({&course, &course, &course}, from_mm, to_mm, out);
}

std::uint64_t InterpolatorProgram::Append(const Vec3& from_mm, const Vec3& to_mm,
                                          std::vector<Segment>& out) const {
  const Vec3 way_mm = (to_mm - from_mm).cwiseAbs();
  Limits shared;
  shared.max_speed_mm_s =
      Shared(limits_.max_speed_mm_s, way_mm, limits_.max_speed_norm_mm_s);
  shared.max_acceleration_mm_s2 =
      Shared(limits_.max_acceleration_mm_s2, way_mm, limits_.max_acceleration_norm_mm_s2);
  const GridCourse x(way_mm.x(), LimitsOf(shared, 0), rate_hz_);
  const GridCourse y(way_mm.y(), LimitsOf(shared, 1), rate_hz_);
  const GridCourse z(way_mm.z(), LimitsOf(shared, 2), rate_hz_);
  return AppendCourses({&x, &y, &z}, from_mm, to_mm, out);
}

}  // namespace intaglio::motion
