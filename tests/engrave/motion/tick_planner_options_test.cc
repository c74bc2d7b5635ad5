// The limits that are options: jerk, lengths of vectors, travel.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engrave/motion/tick_planner.h"
#include "tests/engrave/motion/verified_motion.h"

namespace intaglio::motion {
namespace {

double Unit(std::mt19937_64& random) {
  return std::uniform_real_distribution<double>(0, 1)(random);
}

PointList RandomWalk(std::size_t count, double step_mm, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0, step_mm);
  PointList points;
  Vec3 at(0, 0, 0);
  for (std::size_t i = 0; i < count; ++i) {
    at += Vec3(normal(random), normal(random), 0.2 * normal(random));
    // Jumps, and now and then the same place again.
    if (Unit(random) < 0.05) at += 20 * Vec3(normal(random), normal(random), 0);
    if (Unit(random) < 0.05 && !points.empty()) at = points.back();
    points.push_back(at);
  }
  return points;
}

struct AnyMachine {
  double rate_hz;
  Limits limits;
};

/// From slow to fast, the axes unlike each other.
AnyMachine RandomMachine(std::mt19937_64& random) {
  AnyMachine machine{std::pow(10, 1.7 + 1.9 * Unit(random)), {}};
  for (int axis = 0; axis < 3; ++axis) {
    machine.limits.max_speed_mm_s[axis] = std::pow(10, 1 + 2 * Unit(random));
    machine.limits.max_acceleration_mm_s2[axis] = std::pow(10, 2.5 + 2 * Unit(random));
  }
  return machine;
}

MotionReport PlanAndVerify(const PointList& points, const AnyMachine& machine,
                           const VerifyOptions& verify = {}, double tolerance_mm = 0) {
  std::vector<Segment> segments;
  TickPlannerOptions options = OptionsForRate(machine.rate_hz);
  options.window_points = 40;
  options.look_ahead_points = 15;
  options.tolerance_mm = tolerance_mm;
  TickPlanner planner(machine.limits, machine.rate_hz, options, {});
  for (std::size_t i = 0; i < points.size(); ++i) {
    planner.Append(points[i], static_cast<std::int32_t>(i), true, segments);
  }
  planner.Finish(segments);
  return VerifyMotion({}, segments, points, machine.limits, machine.rate_hz, verify);
}

/// Limits of jerk that are reached after a tenth of a tick to ten ticks.
void LimitJerk(AnyMachine& machine, std::mt19937_64& random) {
  for (int axis = 0; axis < 3; ++axis) {
    if (Unit(random) < 0.2) continue;
    machine.limits.max_jerk_mm_s3[axis] = machine.limits.max_acceleration_mm_s2[axis] *
                                          machine.rate_hz *
                                          std::pow(10, 1 - 2 * Unit(random));
  }
}

void LimitLengths(AnyMachine& machine, std::mt19937_64& random) {
  const Limits& limits = machine.limits;
  machine.limits.max_speed_norm_mm_s =
      limits.max_speed_mm_s.norm() * (0.3 + Unit(random));
  machine.limits.max_acceleration_norm_mm_s2 =
      limits.max_acceleration_mm_s2.norm() * (0.3 + Unit(random));
}

/// A box in which some of the points lie at the walls.
void LimitTravel(AnyMachine& machine, PointList& points, std::mt19937_64& random) {
  Box3 all;
  for (const Vec3& point : points) all.Extend(point);
  Box3& travel = machine.limits.travel_mm;
  for (int axis = 0; axis < 3; ++axis) {
    if (Unit(random) < 0.2) continue;
    travel.min_mm[axis] = std::min(0.0, all.min_mm[axis] * Unit(random));
    travel.max_mm[axis] = std::max(0.0, all.max_mm[axis] * Unit(random));
  }
  for (Vec3& point : points) {
    point = point.cwiseMax(travel.min_mm).cwiseMin(travel.max_mm);
  }
}

TEST(TickPlannerOptions, KeepsTheLimitsOfJerkOfRandomMachines) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 100; ++trial) {
    AnyMachine machine = RandomMachine(random);
    LimitJerk(machine, random);
    const PointList points = RandomWalk(100, std::pow(10, -2 + 2 * Unit(random)), random);
    const MotionReport report = PlanAndVerify(points, machine);
    ASSERT_TRUE(report.ok()) << trial << ": " << machine.rate_hz << " Hz, "
                             << report.violation_count << ": "
                             << report.violations.front();
  }
}

TEST(TickPlannerOptions, KeepsTheLengthsOfTheVectorsOfRandomMachines) {
  std::mt19937_64 random(2);
  for (int trial = 0; trial < 40; ++trial) {
    AnyMachine machine = RandomMachine(random);
    LimitLengths(machine, random);
    const PointList points = RandomWalk(100, std::pow(10, -2 + 2 * Unit(random)), random);
    const MotionReport report = PlanAndVerify(points, machine);
    ASSERT_TRUE(report.ok()) << trial << ": " << report.violations.front();
  }
}

TEST(TickPlannerOptions, StaysInsideTheTravelOfRandomMachines) {
  std::mt19937_64 random(3);
  int near = 0;
  for (int trial = 0; trial < 150; ++trial) {
    AnyMachine machine = RandomMachine(random);
    PointList points = RandomWalk(100, std::pow(10, -2 + 2 * Unit(random)), random);
    LimitTravel(machine, points, random);
    const MotionReport report = PlanAndVerify(points, machine);
    ASSERT_TRUE(report.ok()) << trial << ": " << report.violations.front();
    machine.limits.travel_mm = Limits().travel_mm;
    const Box3 free = PlanAndVerify(points, machine).extent_mm;
    near +=
        report.extent_mm.Contains(free.min_mm) && report.extent_mm.Contains(free.max_mm)
            ? 0
            : 1;
  }
  // Without the limits of travel most of them would have gone further.
  EXPECT_GT(near, 75);
}

TEST(TickPlannerOptions, KeepsThemAllAtOnce) {
  std::mt19937_64 random(4);
  for (int trial = 0; trial < 40; ++trial) {
    AnyMachine machine = RandomMachine(random);
    PointList points = RandomWalk(60, std::pow(10, -2 + 2 * Unit(random)), random);
    LimitJerk(machine, random);
    if (trial % 2 == 0) LimitLengths(machine, random);
    LimitTravel(machine, points, random);
    const MotionReport report = PlanAndVerify(points, machine);
    ASSERT_TRUE(report.ok()) << trial << ": " << report.violations.front();
  }
}

TEST(TickPlannerOptions, MovesNoPointFurtherThanTheTolerance) {
  std::mt19937_64 random(5);
  std::uint64_t ticks = 0, fixed_ticks = 0;
  for (int trial = 0; trial < 80; ++trial) {
    AnyMachine machine = RandomMachine(random);
    PointList points = RandomWalk(100, std::pow(10, -2 + 2 * Unit(random)), random);
    if (trial % 4 == 1) LimitJerk(machine, random);
    if (trial % 2 == 1) LimitTravel(machine, points, random);
    const double tolerance_mm = 0.05 * Unit(random);
    VerifyOptions verify;
    verify.position_tolerance_mm = tolerance_mm * (1 + 1e-9);
    const MotionReport report = PlanAndVerify(points, machine, verify, tolerance_mm);
    ASSERT_TRUE(report.ok()) << trial << ": " << report.violations.front();
    ticks += report.ticks;
    fixed_ticks += PlanAndVerify(points, machine).ticks;
  }
  EXPECT_LT(static_cast<double>(ticks), 0.97 * static_cast<double>(fixed_ticks));
}

TEST(TickPlannerOptions, ReportsHowFarItMovedThePoints) {
  std::mt19937_64 random(6);
  const PointList points = RandomWalk(3000, 0.15, random);
  TickPlannerOptions options;
  options.tolerance_mm = 0.015;
  TickPlanner planner({}, 200, options, {});
  std::vector<Segment> segments;
  for (std::size_t i = 0; i < points.size(); ++i) {
    planner.Append(points[i], static_cast<std::int32_t>(i), true, segments);
  }
  planner.Finish(segments);
  double largest = 0, square = 0;
  for (const Segment& segment : segments) {
    if (segment.point < 0) continue;
    const double move = (segment.end_position_mm - points[segment.point]).norm();
    largest = std::max(largest, move);
    square += move * move;
  }
  EXPECT_NEAR(planner.moves().max_mm, largest, 1e-15);
  EXPECT_NEAR(planner.moves().rms_mm(), std::sqrt(square / 3000), 1e-12);
  EXPECT_LE(largest, 0.015 * (1 + 1e-12));
  EXPECT_GT(largest, 0.014);
  TickPlanner fixed({}, 200, TickPlannerOptions(), {});
  segments.clear();
  for (const Vec3& point : points) fixed.Append(point, 0, true, segments);
  fixed.Finish(segments);
  EXPECT_EQ(fixed.moves().max_mm, 0);
  EXPECT_LT(static_cast<double>(planner.ticks()),
            0.95 * static_cast<double>(fixed.ticks()));
}

}  // namespace
}  // namespace intaglio::motion
