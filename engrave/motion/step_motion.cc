#include "engrave/motion/step_motion.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engrave/motion/step_course.h"

namespace intaglio::motion {
namespace {

/// Where pieces of any axis end, in order.
struct Knots {
  std::array<std::uint64_t, 3 * (StepCourse::kMaxPieces - 1) + 1> at;
  std::size_t count = 0;

  void Add(std::uint64_t knot) {
    std::size_t place = count++;
    for (; place > 0 && at[place - 1] > knot; --place) at[place] = at[place - 1];
    at[place] = knot;
  }
};

/// Whether the cubic is certainly the course of all axes. This cheap check is enough for
/// most steps; where it returns false, StepCourse decides.
bool IsOneCubic(const KnotState& from, const KnotState& to, double seconds,
                const StepLimits& limits) {
  constexpr double kRounding = 1 - 1e-9;
  const Limits& whole = limits.whole;
  const double per_s = 1 / seconds;
  bool fits = true;
  for (int axis = 0; axis < 3; ++axis) {
    const double v = from.velocity_mm_s[axis], w = to.velocity_mm_s[axis];
    const double start = from.position_mm[axis], end = to.position_mm[axis];
    const double top = kRounding * whole.max_speed_mm_s[axis];
    const double largest = kRounding * seconds * whole.max_acceleration_mm_s2[axis];
    const double mean = (end - start) * per_s;
    // Bezier ordinates of the speed are v, the middle one, w. So fast, an axis gets at
    // most half the way it could go in the time beyond its ends.
    const double middle = 3 * mean - v - w, beyond = 0.5 * top * seconds;
    fits &= std::abs(6 * mean - 4 * v - 2 * w) <= largest;
    fits &= std::abs(6 * mean - 2 * v - 4 * w) <= largest;
    fits &= std::max({std::abs(v), std::abs(middle), std::abs(w)}) <= top;
    fits &= whole.travel_mm.min_mm[axis] <= std::min(start, end) - beyond;
    fits &= std::max(start, end) + beyond <= whole.travel_mm.max_mm[axis];
    fits &= !limits.jerk_limited(axis);
  }
  return fits;
}

}  // namespace

void AppendStep(const KnotState& from, const KnotState& to, std::uint32_t ticks,
                const StepLimits& limits, double rate_hz, std::vector<Segment>& out) {
  const std::uint64_t total = std::uint64_t{ticks} * kSubticksPerTick;
  if (ticks <= kMaxSegmentTicks && IsOneCubic(from, to, ticks / rate_hz, limits)) {
    out.push_back({to.position_mm, to.velocity_mm_s, static_cast<std::uint32_t>(total)});
    return;
  }
  const auto course_of = [&](int axis) {
    const AxisStep step{from.position_mm[axis],
                        to.position_mm[axis] - from.position_mm[axis],
                        from.velocity_mm_s[axis], to.velocity_mm_s[axis], total};
    return StepCourse(step, axis, limits, rate_hz);
  };
  const std::array<StepCourse, 3> courses{course_of(0), course_of(1), course_of(2)};
  Knots knots;
  for (const StepCourse& course : courses) {
    for (std::size_t k = 0; k + 1 < course.piece_count(); ++k) knots.Add(course.knot(k));
  }
  knots.Add(total);
  constexpr std::uint64_t kLongest = std::uint64_t{kMaxSegmentTicks} * kSubticksPerTick;
  std::uint64_t at = 0;
  for (std::size_t k = 0; k < knots.count; ++k) {
    while (at < knots.at[k]) {
      const std::uint64_t duration = std::min(knots.at[k] - at, kLongest);
      at += duration;
      Segment segment;
      segment.duration_subticks = static_cast<std::uint32_t>(duration);
      for (int axis = 0; axis < 3 && at < total; ++axis) {
        const auto [gone_mm, speed_mm_s] = courses[axis].At(at);
        segment.end_position_mm[axis] = from.position_mm[axis] + gone_mm;
        segment.end_velocity_mm_s[axis] = speed_mm_s;
      }
      out.push_back(segment);
    }
  }
  out.back().end_position_mm = to.position_mm;
  out.back().end_velocity_mm_s = to.velocity_mm_s;
}

}  // namespace intaglio::motion
