#include "engrave/motion/course_program.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "engrave/core/check.h"

// A step is one course sigma(t) from 0 to 1 that all axes share, position = start +
// sigma step. As in UnitStepLimits it is an axis that goes 1 mm with the limits V, a.
//
// In n ticks, T = n / rate:
//   cubic       sigma = u^2 (3 - 2u), u = t / T; fits if 1.5 / T <= V, 6 / T^2 <= a
//   triangle    two parabolas meeting at T / 2;  fits if 2 / T <= V, 4 / T^2 <= a
//   trapezoid   ramp until t_s, then speed 1 / (T - t_s), ramp down from T - t_s;
//               speed: t_s <= T - 1 / V; acceleration: t_s (T - t_s) >= 1 / a, that is
//               t_s >= SwitchingSeconds(T, 1, a). Of the t_s between these bounds the
//               one nearest T / 3 is taken: the integral of acceleration squared,
//               2 / (t_s (T - t_s)^2), is minimal there.
// Parabolas are Hermite curves exactly. The knots inside a step lie on whole subticks: T
// / 2 always does, t_s is chosen among the whole subticks between its bounds. When there
// is none (T is within a subtick of the minimum time), the step gets one more tick.

namespace intaglio::motion {
namespace {

/// The course of one step in time, 0..1.
struct Course {
  std::uint64_t ticks = 1;
  bool cubic = true;
  std::uint64_t ramp_subticks = 0;  ///< t_s of a triangle or trapezoid

  std::uint64_t subticks() const { return ticks * kSubticksPerTick; }
};

bool FitsCubic(double duration_s, const AxisLimits& unit) {
  return CubicSeconds(1.0, unit) * (1.0 - kTickSlackRatio) <= duration_s;
}

bool FitsTriangle(double duration_s, const AxisLimits& unit) {
  return MinSeconds(Profile::kTriangle, 1.0, unit) * (1.0 - kTickSlackRatio) <=
         duration_s;
}

/// t_s of a trapezoid that fills `subticks`, or nothing.
std::optional<std::uint64_t> RampSubticks(std::uint64_t subticks, double rate_hz,
                                          const AxisLimits& unit) {
  const double subtick_s = DurationSeconds(1, rate_hz);
  const double duration_s = DurationSeconds(subticks, rate_hz);
  const double slack = 1.0 - kTickSlackRatio;
  const double shortest_s =
      slack * SwitchingSeconds(duration_s, 1.0, unit.max_acceleration_mm_s2);
  const double longest_s = duration_s - slack / unit.max_speed_mm_s;
  const auto smallest =
      std::max(static_cast<std::uint64_t>(std::ceil(shortest_s / subtick_s)),
               kShortestArcSubticks);
  if (longest_s < shortest_s) return std::nullopt;
  const auto largest = std::min(static_cast<std::uint64_t>(longest_s / subtick_s),
                                (subticks - kShortestArcSubticks) / 2);
  if (smallest > largest) return std::nullopt;
  return std::clamp(subticks / 3, smallest, largest);
}

/// The course of `profile` over exactly `ticks`, or nothing if it does not fit.
std::optional<Course> CourseOver(std::uint64_t ticks, Profile profile, double rate_hz,
                                 const AxisLimits& unit) {
  Course course{.ticks = ticks};
  const double duration_s = DurationSeconds(course.subticks(), rate_hz);
  const bool try_cubic = profile == Profile::kCubic || profile == Profile::kMix;
  if (try_cubic && FitsCubic(duration_s, unit)) return course;
  if (profile == Profile::kCubic) return std::nullopt;

  course.cubic = false;
  if (profile == Profile::kTrapezoid) {
    if (const auto ramp = RampSubticks(course.subticks(), rate_hz, unit)) {
      course.ramp_subticks = *ramp;
      return course;
    }
  }
  if (FitsTriangle(duration_s, unit)) {
    course.ramp_subticks = course.subticks() / 2;
    return course;
  }
  if (profile == Profile::kMix) {
    if (const auto ramp = RampSubticks(course.subticks(), rate_hz, unit)) {
      course.ramp_subticks = *ramp;
      return course;
    }
  }
  return std::nullopt;
}

Course PlanStep(const Vec3& step_mm, const Limits& limits, double rate_hz,
                Profile profile) {
  const AxisLimits unit = UnitStepLimits(step_mm, limits);
  std::uint64_t ticks = WholeTicks(MinSeconds(profile, 1.0, unit), rate_hz);
  for (;; ++ticks) {
    Require(ticks <= kMaxStepTicks, "a step of ({}, {}, {}) mm takes {} ticks",
            step_mm.x(), step_mm.y(), step_mm.z(), ticks);
    if (const auto course = CourseOver(ticks, profile, rate_hz, unit)) return *course;
  }
}

/// sigma and its speed in 1/s, `at` subticks after the start.
struct Progress {
  double done = 0.0;
  double per_second = 0.0;
};

Progress ProgressAt(const Course& course, std::uint64_t at, double rate_hz) {
  const double t = DurationSeconds(at, rate_hz);
  const double total_s = DurationSeconds(course.subticks(), rate_hz);
  if (course.cubic) {
    const double u = t / total_s;
    return {u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) / total_s};
  }
  const double ramp_s = DurationSeconds(course.ramp_subticks, rate_hz);
  const double cruise_per_s = 1.0 / (total_s - ramp_s);
  const double left_s = DurationSeconds(course.subticks() - at, rate_hz);
  if (at <= course.ramp_subticks) {
    return {0.5 * cruise_per_s * t * t / ramp_s, cruise_per_s * t / ramp_s};
  }
  if (course.subticks() - at <= course.ramp_subticks) {
    return {1.0 - 0.5 * cruise_per_s * left_s * left_s / ramp_s,
            cruise_per_s * left_s / ramp_s};
  }
  return {cruise_per_s * (t - 0.5 * ramp_s), cruise_per_s};
}

}  // namespace

std::uint64_t CourseProgram::Append(const Vec3& from_mm, const Vec3& to_mm,
                                    std::vector<Segment>& out) const {
  const Vec3 step_mm = to_mm - from_mm;
  const Course course = PlanStep(step_mm, limits_, rate_hz_, profile_);
  const std::uint64_t end = course.subticks();
  // Where arcs meet; of a cubic and a triangle some of them coincide.
  const std::array<std::uint64_t, 3> knots = {course.ramp_subticks,
                                              end - course.ramp_subticks, end};
  AppendThroughKnots(
      knots,
      [&](std::uint64_t at) {
        const Progress progress = ProgressAt(course, at, rate_hz_);
        return KnotState{from_mm + progress.done * step_mm,
                         progress.per_second * step_mm};
      },
      out);
  EndAtRest(to_mm, out.back());
  return course.ticks;
}

}  // namespace intaglio::motion
