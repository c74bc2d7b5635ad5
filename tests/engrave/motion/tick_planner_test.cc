#include "engrave/motion/tick_planner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engrave/core/check.h"
#include "engrave/motion/axis/axis_reach.h"
#include "tests/engrave/motion/paths.h"
#include "tests/engrave/motion/stop_and_go_ticks.h"
#include "tests/engrave/motion/verified_motion.h"

namespace intaglio::motion {
namespace {

PointList RandomWalk(std::size_t count, double step_mm, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, step_mm);
  std::uniform_int_distribution<int> one_in(0, 19);
  PointList points;
  Vec3 at(0, 0, 0);
  for (std::size_t i = 0; i < count; ++i) {
    at += Vec3(normal(random), normal(random), 0.2 * normal(random));
    // Jumps, and now and then the same place again.
    if (one_in(random) == 0) at += 20 * Vec3(normal(random), normal(random), 0);
    if (one_in(random) == 0 && !points.empty()) at = points.back();
    points.push_back(at);
  }
  return points;
}

struct Plan {
  std::vector<Segment> segments;
  std::uint64_t ticks = 0;
};

Plan PlanAll(const PointList& points, const Limits& limits, double rate_hz,
             const TickPlannerOptions& options, const KnotState& start = {}) {
  Plan plan;
  TickPlanner planner(limits, rate_hz, options, start);
  for (std::size_t i = 0; i < points.size(); ++i) {
    planner.Append(points[i], static_cast<std::int32_t>(i), true, plan.segments);
  }
  planner.Finish(plan.segments);
  plan.ticks = planner.ticks();
  return plan;
}

struct Machine {
  double rate_hz, speed_mm_s, acceleration_mm_s2;
};

class TickPlannerOn : public ::testing::TestWithParam<Machine> {
 protected:
  Limits limits() const {
    // The axes differ, so that mixing them up shows.
    return {GetParam().speed_mm_s * Vec3(1, 0.9, 0.5),
            GetParam().acceleration_mm_s2 * Vec3(1, 0.8, 0.6)};
  }
};

TEST_P(TickPlannerOn, PassesEveryPointAtATickWithinAllLimits) {
  const double rate_hz = GetParam().rate_hz;
  for (const double step_mm : {0.01, 0.1, 0.7}) {
    const PointList points = RandomWalk(700, step_mm, 5);
    const Plan plan = PlanAll(points, limits(), rate_hz, OptionsForRate(rate_hz));
    const MotionReport report =
        VerifyMotion({}, plan.segments, points, limits(), rate_hz);
    ASSERT_TRUE(report.ok()) << step_mm << ": " << report.violations.front();
    EXPECT_EQ(report.points, points.size());
    EXPECT_EQ(report.ticks, plan.ticks);
  }
}

TEST_P(TickPlannerOn, TakesNoMoreTicksThanStoppingAndNoFewerThanTheBounds) {
  const double rate_hz = GetParam().rate_hz;
  for (const double step_mm : {0.01, 0.1, 0.7}) {
    const PointList points = RandomWalk(700, step_mm, 6);
    const std::uint64_t ticks =
        PlanAll(points, limits(), rate_hz, OptionsForRate(rate_hz)).ticks;
    const std::uint64_t stopping =
        StopAndGoTicks(points, Vec3::Zero(), limits(), rate_hz, Profile::kMix);
    // The reserve for arcs on a grid sometimes costs a tick.
    EXPECT_LE(static_cast<double>(ticks), 1.002 * static_cast<double>(stopping));
    double min_s = 0;
    Vec3 at = Vec3::Zero();
    for (const Vec3& point : points) {
      min_s +=
          ((point - at).cwiseAbs().array() / limits().max_speed_mm_s.array()).maxCoeff();
      at = point;
    }
    EXPECT_GE(static_cast<double>(ticks), min_s * rate_hz);
    EXPECT_GE(ticks, points.size());
  }
}

INSTANTIATE_TEST_SUITE_P(
    Machines, TickPlannerOn,
    ::testing::Values(Machine{50, 80, 7000}, Machine{100, 80, 2000},
                      Machine{200, 80, 10000}, Machine{500, 80, 7000},
                      Machine{1000, 1000, 20000}, Machine{4000, 80, 7000}),
    [](const auto& machine) {
      return std::to_string(static_cast<int>(machine.param.rate_hz)) + "_hz";
    });

// Machines from slow to fast, ways from fine to coarse, labels and windows from few to
// many.
TEST(TickPlanner, KeepsEveryLimitOfRandomMachines) {
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int trial = 0; trial < 400; ++trial) {
    const double rate_hz = std::pow(10, 1.7 + 1.9 * unit(random));
    Limits limits;
    for (int axis = 0; axis < 3; ++axis) {
      limits.max_speed_mm_s[axis] = std::pow(10, 1 + 2 * unit(random));
      limits.max_acceleration_mm_s2[axis] = std::pow(10, 2.5 + 2 * unit(random));
    }
    TickPlannerOptions options = OptionsForRate(rate_hz);
    options.labels.width = 1 + trial % 6;
    options.window_points = 20 + trial % 50;
    options.look_ahead_points = trial % 20;
    options.sweeps = trial % 5;
    const PointList points = RandomWalk(150, std::pow(10, -2 + 2 * unit(random)), trial);
    const Plan plan = PlanAll(points, limits, rate_hz, options);
    const MotionReport report = VerifyMotion({}, plan.segments, points, limits, rate_hz);
    ASSERT_TRUE(report.ok()) << rate_hz << " Hz: " << report.violations.front();
  }
}

// The fewest ticks of three steps on one axis, by trying all counts and all speeds of a
// grid: none of them may beat the planner.
TEST(TickPlanner, NoCombinationOfAGridIsShorter) {
  const Limits limits;
  const double rate_hz = 200;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto feasible = [&](double v, double w, double d, int ticks) {
    const double seconds = ticks / rate_hz;
    if (std::abs(d) >= 80 * seconds) return false;
    return GentlestArcs(v, w, d, seconds, 80).peak_acceleration_mm_s2 <=
           7000 * (1 - 3e-4);  // more than the planner keeps in reserve
  };
  for (int trial = 0; trial < 40; ++trial) {
    const double d[3] = {0.4 * unit(random), 0.4 * unit(random), 0.4 * unit(random)};
    int best = INT32_MAX;
    for (int a = 1; a <= 5; ++a) {
      for (int b = 1; b <= 5; ++b) {
        for (int c = 1; c <= 5; ++c) {
          if (a + b + c >= best) continue;
          bool found = false;
          for (double v = -79; v <= 79 && !found; v += 2) {
            if (!feasible(0, v, d[0], a)) continue;
            for (double w = -79; w <= 79 && !found; w += 2) {
              found = feasible(v, w, d[1], b) && feasible(w, 0, d[2], c);
            }
          }
          if (found) best = a + b + c;
        }
      }
    }
    PointList points;
    Vec3 at = Vec3::Zero();
    for (const double step : d) points.push_back(at += Vec3(0, step, 0));
    EXPECT_LE(PlanAll(points, limits, rate_hz, {.labels = {64, 8}}).ticks,
              static_cast<std::uint64_t>(best));
  }
}

TEST(TickPlanner, AWindowCostsHardlyATick) {
  const PointList points = RandomWalk(4000, 0.15, 8);
  TickPlannerOptions whole;
  whole.window_points = 5000;
  const auto all = PlanAll(points, {}, 200, whole).ticks;
  const auto windows = PlanAll(points, {}, 200, {}).ticks;
  EXPECT_LE(static_cast<double>(windows), 1.0005 * static_cast<double>(all));
}

TEST(TickPlanner, HandsOutAWindowAndCanAlwaysEndAtRest) {
  const PointList points = RandomWalk(2000, 0.15, 9);
  TickPlannerOptions options;
  options.window_points = 64;
  options.look_ahead_points = 32;
  TickPlanner planner({}, 100, options, {});
  std::vector<Segment> out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    planner.Append(points[i], static_cast<std::int32_t>(i), true, out);
    // A copy of it ends here: the motion returned so far can be brought to rest.
    if (i % 37 == 0) {
      TickPlanner ending = planner;
      std::vector<Segment> whole = out;
      ending.Finish(whole);
      const PointList so_far(points.begin(), points.begin() + i + 1);
      const MotionReport report = VerifyMotion({}, whole, so_far, {}, 100);
      ASSERT_TRUE(report.ok()) << report.violations.front();
      EXPECT_EQ(report.points, so_far.size());
    }
  }
}

TEST(TickPlanner, GoesOnFromAMovingStart) {
  const KnotState start{Vec3(1, 2, 3), Vec3(70, -50, 20)};
  const PointList points = {Vec3(1.3, 1.9, 3), Vec3(1.4, 1.9, 3.1)};
  for (const double rate_hz : {50.0, 200.0, 4000.0}) {
    const Plan plan = PlanAll(points, {}, rate_hz, OptionsForRate(rate_hz), start);
    // VerifyMotion expects a start at rest; that is the only violation it may report.
    const MotionReport report = VerifyMotion(start, plan.segments, points, {}, rate_hz);
    EXPECT_LE(report.violation_count, 1u);
    EXPECT_EQ(report.points, points.size());
  }
}

TEST(TickPlanner, AProgramWithoutPointsIsATickAtRest) {
  const KnotState start{Vec3(1, 2, 3), Vec3::Zero()};
  const Plan plan = PlanAll({}, {}, 100, {}, start);
  ASSERT_EQ(plan.segments.size(), 1u);
  EXPECT_TRUE(plan.segments[0].program_end);
  EXPECT_EQ(plan.segments[0].end_position_mm, start.position_mm);
  EXPECT_EQ(plan.ticks, 1u);
}

TEST(TickPlanner, TheSameTwiceBitForBit) {
  const PointList points = RandomWalk(3000, 0.15, 10);
  const Plan a = PlanAll(points, {}, 200, {}), b = PlanAll(points, {}, 200, {});
  ASSERT_EQ(a.segments.size(), b.segments.size());
  for (std::size_t i = 0; i < a.segments.size(); ++i) {
    ASSERT_EQ(a.segments[i].end_position_mm, b.segments[i].end_position_mm);
    ASSERT_EQ(a.segments[i].end_velocity_mm_s, b.segments[i].end_velocity_mm_s);
    ASSERT_EQ(a.segments[i].duration_subticks, b.segments[i].duration_subticks);
  }
}

TEST(TickPlanner, SweepsLowerTheAccelerationAndCostNoTick) {
  const PointList points = RandomWalk(2000, 0.1, 11);
  TickPlannerOptions rough, smooth;
  rough.sweeps = 0;
  const Plan a = PlanAll(points, {}, 100, rough), b = PlanAll(points, {}, 100, smooth);
  EXPECT_EQ(a.ticks, b.ticks);
  const auto rms = [&](const Plan& plan) {
    return VerifyMotion({}, plan.segments, points, {}, 100).rms_acceleration_mm_s2;
  };
  EXPECT_LT(rms(b), rms(a));
}

TEST(TickPlanner, WrongOptionsThrow) {
  EXPECT_THROW(TickPlanner({}, 0, {}, {}), PreconditionError);
  TickPlannerOptions blind;
  blind.look_ahead_points = blind.window_points;
  EXPECT_THROW(TickPlanner({}, 100, blind, {}), PreconditionError);
}

// The order and the machine of Trochimczuk 2008, whose stops leave .829 at 100 Hz and
// .524 at 200 Hz.
TEST(TickPlanner, UsesThePulsesThatStoppingLosesOnThePublishedOrder) {
  PointList points = FittedPoints("calibrated_ordered");
  ASSERT_EQ(points.size(), 16179u);
  const KnotState start{points.front(), Vec3::Zero()};
  points.erase(points.begin());
  for (const auto& [rate_hz, utilisation] :
       {std::pair{50.0, 0.988}, {100.0, 0.9637}, {200.0, 0.752}}) {
    const Plan plan = PlanAll(points, {}, rate_hz, OptionsForRate(rate_hz), start);
    const MotionReport report = VerifyMotion(start, plan.segments, points, {}, rate_hz);
    ASSERT_TRUE(report.ok()) << report.violations.front();
    EXPECT_GE(UtilisationRatio(report), utilisation) << rate_hz;
  }
}

}  // namespace
}  // namespace intaglio::motion
