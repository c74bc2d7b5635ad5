#include "engrave/motion/step_motion.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "engrave/motion/axis_reach.h"

// Arcs begin and end on a grid. With first and last fixed, an axis cruises at the speed
// that still goes the whole way:
//   d = (v + c) f / 2 + c (T - f - l) + (c + w) l / 2
//   c = (d - v f / 2 - w l / 2) / (T - (f + l) / 2).
// Two arcs: the shorter one is made longer by e < grid. It then needs less acceleration
// than before, and the other at most 4 e / T of it more.
// With a cruise: the longer one is made longer. For it, too, less acceleration is enough,
// and the shorter one is solved again, now from the other's rounded time f,
//   x = c - w,  l = |x| / a,  x (T - f / 2) - x |x| / (2 a) = d - v f / 2 - w (T - f /
//   2),
// before it is made longer in turn, which raises no acceleration by more than e / T.

namespace intaglio::motion {
namespace {

/// The grid is at least this: over shorter times the last bit of a coordinate shows as
/// acceleration (1.4e-14 mm of 100 mm: 2 mm/s^2).
constexpr double kGridSeconds = 0.2e-6;

std::uint64_t GridSubticks(double rate_hz) {
  return std::bit_ceil(
      static_cast<std::uint64_t>(std::ceil(kGridSeconds * rate_hz * kSubticksPerTick)));
}

/// The course of one axis over a step.
struct Course {
  bool cubic = true;
  std::uint64_t first = 0;  ///< Subticks of the first and of the last arc.
  std::uint64_t last = 0;
  double cruise_mm_s = 0;
};

bool CubicFits(double v, double w, double d, double seconds, const AxisLimits& limits) {
  const double a = (6 * d / seconds - 4 * v - 2 * w) / seconds;
  const double b = (-6 * d / seconds + 2 * v + 4 * w) / seconds;
  if (std::max(std::abs(a), std::abs(b)) > limits.max_acceleration_mm_s2) return false;
  // The acceleration falls linearly from a to b; where it is 0 the speed is extreme.
  if ((a > 0) == (b > 0)) return true;
  const double extreme = v + 0.5 * a * a * seconds / (a - b);
  return std::abs(extreme) <= limits.max_speed_mm_s;
}

/// The next duration on the grid.
std::uint64_t OnGrid(double seconds, double rate_hz, std::uint64_t longest) {
  const std::uint64_t grid = GridSubticks(rate_hz);
  const double steps = seconds * rate_hz * (kSubticksPerTick / static_cast<double>(grid));
  return std::min(grid * static_cast<std::uint64_t>(std::ceil(steps)), longest);
}

/// l of the derivation: `near` is the speed at the end whose arc has its time.
double OtherArc(double near, double far, double d, double near_s, double seconds,
                double acceleration) {
  const double p = seconds - 0.5 * near_s;
  const double q = d - 0.5 * near * near_s - far * p;
  const double root = std::sqrt(std::max(0.0, p * p - 2 * std::abs(q) / acceleration));
  return 2 * std::abs(q) / ((p + root) * acceleration);
}

Course CourseOf(double v, double w, double d, std::uint64_t total, double rate_hz,
                const AxisLimits& limits, const AxisLimits& planning) {
  const double seconds = DurationSeconds(total, rate_hz);
  if (CubicFits(v, w, d, seconds, limits)) return {};
  const Arcs arcs = GentlestArcs(v, w, d, seconds, planning.max_speed_mm_s);
  Course course{.cubic = false};
  const bool first_is_longer = arcs.first_s > arcs.last_s;
  std::uint64_t& longer = first_is_longer ? course.first : course.last;
  std::uint64_t& shorter = first_is_longer ? course.last : course.first;
  if (arcs.first_s + arcs.last_s < seconds * (1 - 1e-12)) {
    longer = OnGrid(std::max(arcs.first_s, arcs.last_s), rate_hz, total);
    const double longer_s = DurationSeconds(longer, rate_hz);
    const double shorter_s =
        first_is_longer
            ? OtherArc(v, w, d, longer_s, seconds, arcs.peak_acceleration_mm_s2)
            : OtherArc(w, v, d, longer_s, seconds, arcs.peak_acceleration_mm_s2);
    shorter = OnGrid(shorter_s, rate_hz, total - longer);
  } else {
    shorter = OnGrid(std::min(arcs.first_s, arcs.last_s), rate_hz, total);
    longer = total - shorter;
  }
  const double first_s = DurationSeconds(course.first, rate_hz);
  const double last_s = DurationSeconds(course.last, rate_hz);
  course.cruise_mm_s =
      (d - 0.5 * v * first_s - 0.5 * w * last_s) / (seconds - 0.5 * (first_s + last_s));
  return course;
}

/// Position after the start and speed of one axis, `at` subticks after the start.
std::array<double, 2> StateAt(const Course& course, double v, double w, double d,
                              std::uint64_t at, std::uint64_t total, double rate_hz) {
  const double t = DurationSeconds(at, rate_hz);
  const double seconds = DurationSeconds(total, rate_hz);
  if (course.cubic) {
    const double u = t / seconds;
    const double a = (6 * d / seconds - 4 * v - 2 * w) / seconds;
    const double b = (-6 * d / seconds + 2 * v + 4 * w) / seconds;
    return {t * (v + t * (0.5 * a + u * (b - a) / 6)), v + t * (a + 0.5 * u * (b - a))};
  }
  const double c = course.cruise_mm_s;
  if (at < course.first) {
    const double first_s = DurationSeconds(course.first, rate_hz);
    const double speed = v + (c - v) * t / first_s;
    return {0.5 * (v + speed) * t, speed};
  }
  if (total - at < course.last) {
    const double last_s = DurationSeconds(course.last, rate_hz);
    const double left = seconds - t;
    const double speed = w + (c - w) * left / last_s;
    return {d - 0.5 * (w + speed) * left, speed};
  }
  const double first_s = DurationSeconds(course.first, rate_hz);
  return {0.5 * (v + c) * first_s + c * (t - first_s), c};
}

/// Where arcs of any axis meet, in order; two an axis, and the end.
struct Knots {
  std::array<std::uint64_t, 7> at{};
  std::size_t count = 0;

  void Add(std::uint64_t knot) {
    std::size_t place = count++;
    for (; place > 0 && at[place - 1] > knot; --place) at[place] = at[place - 1];
    at[place] = knot;
  }
};

}  // namespace

Limits LimitsForPlanning(const Limits& limits, double rate_hz) {
  const double grid_ticks = static_cast<double>(GridSubticks(rate_hz)) / kSubticksPerTick;
  const Vec3 a = limits.max_acceleration_mm_s2 * (1 - 4 * grid_ticks);
  // A longer arc makes the cruise faster by no more than it accelerates meanwhile.
  return {limits.max_speed_mm_s - a * (2 * grid_ticks / rate_hz), a};
}

void AppendStep(const KnotState& from, const KnotState& to, std::uint32_t ticks,
                const Limits& limits, double rate_hz, std::vector<Segment>& out) {
  const std::uint64_t total = std::uint64_t{ticks} * kSubticksPerTick;
  const Vec3 step_mm = to.position_mm - from.position_mm;
  std::array<Course, 3> courses;
  Knots knots;
  const Limits planning = LimitsForPlanning(limits, rate_hz);
  for (int axis = 0; axis < 3; ++axis) {
    Course& course = courses[axis];
    course = CourseOf(from.velocity_mm_s[axis], to.velocity_mm_s[axis], step_mm[axis],
                      total, rate_hz, LimitsOf(limits, axis), LimitsOf(planning, axis));
    if (course.cubic) continue;
    knots.Add(course.first);
    knots.Add(total - course.last);
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
      for (int axis = 0; axis < 3; ++axis) {
        const auto [gone, speed] =
            StateAt(courses[axis], from.velocity_mm_s[axis], to.velocity_mm_s[axis],
                    step_mm[axis], at, total, rate_hz);
        segment.end_position_mm[axis] = from.position_mm[axis] + gone;
        segment.end_velocity_mm_s[axis] = speed;
      }
      out.push_back(segment);
    }
  }
  out.back().end_position_mm = to.position_mm;
  out.back().end_velocity_mm_s = to.velocity_mm_s;
}

}  // namespace intaglio::motion
