// Each step that is feasible within the planned limits keeps the whole ones after its
// arcs were moved to the grid. Oracle: the accelerations at both ends of each segment and
// its fastest moment, from position and speed alone.

#include "engrave/motion/step_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include "engrave/motion/axis/axis_reach.h"
#include "engrave/motion/axis/jerk_reach.h"

namespace intaglio::motion {
namespace {

struct SteppedAxis {
  const char* name;
  double rate_hz, speed_mm_s, acceleration_mm_s2;
  double jerk_mm_s3 = kUnlimited;
};

/// Shares of the limits that one axis reaches.
struct Peaks {
  double speed = 0, acceleration = 0, jerk = 0;
};

Peaks PeaksOf(const KnotState& start, const std::vector<Segment>& segments, int axis,
              const SteppedAxis& machine) {
  Peaks peaks;
  KnotState from = start;
  for (const Segment& to : segments) {
    const double t = DurationSeconds(to.duration_subticks, machine.rate_hz);
    const double v = from.velocity_mm_s[axis], w = to.end_velocity_mm_s[axis];
    const double mean = (to.end_position_mm[axis] - from.position_mm[axis]) / t;
    const double a = (6 * mean - 4 * v - 2 * w) / t, b = (2 * v + 4 * w - 6 * mean) / t;
    double speed = std::max(std::abs(v), std::abs(w));
    if (a * b < 0) speed = std::max(speed, std::abs(v + 0.5 * a * a * t / (a - b)));
    peaks.speed = std::max(peaks.speed, speed / machine.speed_mm_s);
    peaks.acceleration = std::max(peaks.acceleration, std::max(std::abs(a), std::abs(b)) /
                                                          machine.acceleration_mm_s2);
    peaks.jerk = std::max(peaks.jerk, std::abs(b - a) / t / machine.jerk_mm_s3);
    from = to.end();
  }
  return peaks;
}

/// A feasible step of one axis, if these draws make one. Ends of ranges are what a
/// planner chooses, so they are drawn often.
template <typename AxisLimitsT>
std::optional<std::pair<KnotState, KnotState>> RandomStep(std::mt19937& random,
                                                          double seconds,
                                                          const AxisLimitsT& planned) {
  std::uniform_real_distribution<double> share(-1, 1);
  const auto in = [&](const SpeedInterval& range) {
    const double at = std::clamp(1.5 * share(random), -1.0, 1.0);
    return range.Clamp(0.5 * (range.lo + range.hi + at * (range.hi - range.lo)));
  };
  const double distance = share(random) * planned.max_speed_mm_s * seconds;
  const SpeedInterval starts = UsableStartSpeeds(distance, seconds, planned);
  if (starts.empty()) return std::nullopt;
  const double v = in(starts);
  const SpeedInterval ends = ReachableEndSpeeds({v, v}, distance, seconds, planned);
  if (ends.empty()) return std::nullopt;
  return std::pair(KnotState{Vec3::Zero(), {0, v, 0}},
                   KnotState{{0, distance, 0}, {0, in(ends), 0}});
}

class StepMotion : public ::testing::TestWithParam<SteppedAxis> {};

TEST_P(StepMotion, KeepsTheLimitsOfEveryFeasibleStep) {
  const SteppedAxis& machine = GetParam();
  Limits limits;
  limits.max_speed_mm_s = Vec3::Constant(machine.speed_mm_s);
  limits.max_acceleration_mm_s2 = Vec3::Constant(machine.acceleration_mm_s2);
  limits.max_jerk_mm_s3 = Vec3::Constant(machine.jerk_mm_s3);
  const StepLimits step_limits = StepLimitsOf(limits, machine.rate_hz).front();
  const Limits& planned = step_limits.planned;
  std::mt19937 random(5);
  int made = 0;
  Peaks largest;
  for (int i = 0; i < 300000 && !HasFailure(); ++i) {
    const auto ticks = static_cast<std::uint32_t>(1 + random() % 3);
    const double seconds = ticks / machine.rate_hz;
    const auto step = step_limits.jerk_limited(1)
                          ? RandomStep(random, seconds, JerkLimitsOf(planned, 1))
                          : RandomStep(random, seconds, LimitsOf(planned, 1));
    if (!step) continue;
    const auto& [from, to] = *step;
    std::vector<Segment> segments;
    AppendStep(from, to, ticks, step_limits, machine.rate_hz, segments);
    const Peaks peaks = PeaksOf(from, segments, 1, machine);
    for (const double peak : {peaks.speed, peaks.acceleration, peaks.jerk}) {
      EXPECT_LT(peak, 1 + 1e-6)
          << ticks << " ticks, " << to.position_mm.y() << " mm, from "
          << from.velocity_mm_s.y() << " to " << to.velocity_mm_s.y() << " mm/s";
    }
    largest = {std::max(largest.speed, peaks.speed),
               std::max(largest.acceleration, peaks.acceleration),
               std::max(largest.jerk, peaks.jerk)};
    ++made;
  }
  EXPECT_GT(made, 100000);
  RecordProperty("speed", std::to_string(largest.speed));
  RecordProperty("acceleration", std::to_string(largest.acceleration));
  RecordProperty("jerk", std::to_string(largest.jerk));
}

INSTANTIATE_TEST_SUITE_P(, StepMotion,
                         ::testing::Values(SteppedAxis{"Mirrors2kHz", 2000, 8000, 5e7},
                                           SteppedAxis{"Mirrors10kHz", 10000, 8000, 5e7},
                                           SteppedAxis{"Mirrors20kHz", 20000, 8000, 5e7},
                                           SteppedAxis{"Mirrors50kHz", 50000, 8000, 5e7},
                                           SteppedAxis{"Stage", 100, 80, 7000},
                                           SteppedAxis{"SlowStage", 1000, 50, 1000},
                                           SteppedAxis{"Jerk100Hz", 100, 80, 7000, 1e6},
                                           SteppedAxis{"Jerk200Hz", 200, 80, 7000, 5e6},
                                           SteppedAxis{"Jerk1kHz", 1000, 80, 7000, 1e7},
                                           SteppedAxis{"HighJerk1kHz", 1000, 80, 7000,
                                                       1e8}),
                         [](const auto& row) { return row.param.name; });

}  // namespace
}  // namespace intaglio::motion
