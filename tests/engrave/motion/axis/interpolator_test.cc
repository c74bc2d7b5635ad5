#include "engrave/motion/axis/interpolator.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "engrave/motion/interpolator_program.h"

namespace intaglio::motion {
namespace {

constexpr AxisLimits kPublished{80.0, 7000.0};

TEST(TimeOptimal, NoChoiceWithinTheLimitsIsFaster) {
  for (const double l : {0.01, 0.3, 0.914, 0.915, 2.0, 40.0}) {
    const TimeOptimalChoice best = ChooseTimeOptimal(l, kPublished);
    EXPECT_LE(best.speed_mm_s, 80.0);
    EXPECT_LE(best.acceleration_mm_s2, 7000.0);
    for (int i = 1; i <= 200; ++i) {
      for (int j = 1; j <= 50; ++j) {
        const double v = 80.0 * i / 200;
        const double a = 7000.0 * j / 50;
        EXPECT_GE(l / v + v / a, best.seconds * (1 - 1e-12)) << l;
      }
    }
  }
}

TEST(TimeOptimal, IsThePrintedTimeOfItsCase) {
  // (85) and the line below it.
  EXPECT_NEAR(ChooseTimeOptimal(0.5, kPublished).seconds, 2 * std::sqrt(0.5 / 7000),
              1e-15);
  EXPECT_NEAR(ChooseTimeOptimal(5.0, kPublished).seconds, 5.0 / 80 + 80.0 / 7000, 1e-15);
  // The minimum lies where (83) vanishes: the derivative of (81) by differences.
  const double v = ChooseTimeOptimal(0.5, kPublished).speed_mm_s;
  const auto time_s = [](double speed) { return 0.5 / speed + speed / 7000; };
  EXPECT_NEAR((time_s(v + 1e-3) - time_s(v - 1e-3)) / 2e-3, 0.0, 1e-9);
}

TEST(TimeOptimal, IsTheMinimumTimeOfStopAndGo) {
  for (double l = 1e-4; l < 300; l *= 1.7) {
    EXPECT_NEAR(ChooseTimeOptimal(l, kPublished).seconds, StopAndGoSeconds(l, kPublished),
                1e-14);
  }
}

/// Where the acceleration of a way under kPublished jumps, by the printed formulas.
struct Switches {
  double speed_mm_s;  // V_M
  double t1_s, t2_s, end_s;
};

Switches SwitchesOf(double way_mm) {
  const double v = std::min(std::sqrt(way_mm * 7000.0), 80.0);
  const double t1_s = v / 7000.0;
  const double t2_s = t1_s + std::max(0.0, way_mm - v * v / 7000.0) / v;
  return {v, t1_s, t2_s, t2_s + t1_s};
}

/// The acceleration changes from `before` to `after` within 1e-9 of `at_s`.
void ExpectJump(const Interpolator& axis, double at_s, double before_mm_s2,
                double after_mm_s2) {
  EXPECT_EQ(axis.At(at_s * (1 - 1e-9)).acceleration_mm_s2, before_mm_s2) << at_s;
  EXPECT_EQ(axis.At(at_s * (1 + 1e-9)).acceleration_mm_s2, after_mm_s2) << at_s;
}

TEST(Interpolator, SwitchesWhereThePrintedFormulasState) {
  const Interpolator axis(10.0, 15.0, kPublished);
  const double t1_s = 80.0 / 7000;
  const double t2_s = 80.0 / 7000 + (5.0 - 80.0 * 80.0 / 7000) / 80.0;
  ExpectJump(axis, t1_s, 7000.0, 0.0);
  ExpectJump(axis, t2_s, 0.0, -7000.0);
  ExpectJump(axis, t1_s + t2_s, -7000.0, 0.0);
  EXPECT_DOUBLE_EQ(axis.At(t1_s).position_mm, 10.0 + 80.0 * 80.0 / 14000);
  EXPECT_DOUBLE_EQ(axis.At(t2_s).position_mm, 15.0 - 80.0 * 80.0 / 14000);
}

/// Sums the acceleration over small times, split where it jumps.
void ExpectIntegralOfItsAcceleration(const Interpolator& axis, double start_mm,
                                     const Switches& switches) {
  double position_mm = start_mm;
  double speed_mm_s = 0.0;
  const double ends[] = {0.0, switches.t1_s, switches.t2_s, switches.end_s};
  for (int arc = 0; arc < 3; ++arc) {
    const double dt = (ends[arc + 1] - ends[arc]) / 100;
    for (int k = 0; k < 100 && dt > 0; ++k) {
      const double t = ends[arc] + k * dt;
      const double a = axis.At(t + 0.5 * dt).acceleration_mm_s2;
      position_mm += speed_mm_s * dt + 0.5 * a * dt * dt;
      speed_mm_s += a * dt;
      const AxisState state = axis.At(t + dt * (1 - 1e-12));
      // Sums of a hundred doubles.
      ASSERT_NEAR(state.position_mm, position_mm, 1e-9);
      ASSERT_NEAR(state.speed_mm_s, speed_mm_s, 1e-7);
      ASSERT_LE(std::abs(state.speed_mm_s), 80.0 * (1 + 1e-12));
      ASSERT_LE(std::abs(state.acceleration_mm_s2), 7000.0);
    }
  }
}

TEST(Interpolator, IsTheIntegralOfItsAccelerationInBothDirections) {
  for (const double way_mm : {0.02, 0.9, 1.0, 33.0}) {
    for (const double sign : {1.0, -1.0}) {
      const Interpolator axis(3.0, 3.0 + sign * way_mm, kPublished);
      const Switches switches = SwitchesOf(way_mm);
      ExpectIntegralOfItsAcceleration(axis, 3.0, switches);
      EXPECT_NEAR(axis.At(switches.end_s).position_mm, 3.0 + sign * way_mm, 1e-12);
      EXPECT_NEAR(axis.At(switches.end_s).speed_mm_s, 0.0, 1e-11);
      EXPECT_EQ(axis.At(switches.end_s + 1).position_mm, 3.0 + sign * way_mm);
      EXPECT_EQ(axis.At(-1).position_mm, 3.0);
    }
  }
}

TEST(Interpolator, AWayTooShortForTheSpeedHasNoCruise) {
  const Interpolator axis(0.0, 0.5, kPublished);
  const double end_s = TriangleSeconds(0.5, 7000.0);
  ExpectJump(axis, end_s / 2, 7000.0, -7000.0);
  ExpectJump(axis, end_s, -7000.0, 0.0);
  EXPECT_NEAR(axis.At(end_s / 2).position_mm, 0.25, 1e-15);
  EXPECT_NEAR(axis.At(end_s / 2).speed_mm_s, std::sqrt(0.5 * 7000.0), 1e-12);
}

TEST(Interpolator, NoWayTakesNoTime) {
  const Interpolator axis(2.0, 2.0, kPublished);
  for (const double t_s : {0.0, 1e-300, 1.0}) {
    EXPECT_EQ(axis.At(t_s).position_mm, 2.0);
    EXPECT_EQ(axis.At(t_s).speed_mm_s, 0.0);
    EXPECT_EQ(axis.At(t_s).acceleration_mm_s2, 0.0);
  }
}

TEST(InterpolatorProgram, DrivesAtItsLimitsAndWaits) {
  const Limits limits;
  std::vector<Segment> segments;
  const std::uint64_t ticks =
      TimeOptimalProgram(limits, 100.0).Append(Vec3::Zero(), Vec3(5, -2, 1), segments);
  EXPECT_EQ(ticks, 8u);  // 73.9 ms
  ASSERT_EQ(segments.size(), 4u);
  std::uint64_t moving = 0;
  for (int i = 0; i < 3; ++i) moving += segments[i].duration_subticks;
  // Up to three lengths of the grid longer than (81).
  const double late_s =
      DurationSeconds(moving, 100.0) - ChooseTimeOptimal(5.0, kPublished).seconds;
  EXPECT_GE(late_s, -1e-10);
  EXPECT_LE(late_s, 3 * DurationSeconds(kGridSubticks, 100.0));
  EXPECT_EQ(segments[2].end_position_mm, Vec3(5, -2, 1));
  EXPECT_EQ(segments[3].end_position_mm, Vec3(5, -2, 1));
  EXPECT_TRUE(segments[3].end_velocity_mm_s.isZero(0.0));
  // The way is straight.
  for (const Segment& segment : segments) {
    EXPECT_LT(segment.end_position_mm.cross(Vec3(5, -2, 1)).norm(), 1e-12);
  }
}

TEST(InterpolatorProgram, EveryAxisArrivesByItself) {
  const Limits limits;
  std::vector<Segment> segments;
  InterpolatorProgram(limits, 100.0).Append(Vec3::Zero(), Vec3(5, 0.5, 0), segments);
  const double grid_s = DurationSeconds(kGridSubticks, 100.0);
  for (const int axis : {0, 1}) {
    std::uint64_t at = 0;
    for (const Segment& segment : segments) {
      at += segment.duration_subticks;
      if (segment.end_position_mm[axis] == Vec3(5, 0.5, 0)[axis]) break;
    }
    const double min_s = StopAndGoSeconds(Vec3(5, 0.5, 0)[axis], kPublished);
    EXPECT_NEAR(DurationSeconds(at, 100.0), min_s, 3 * grid_s);
  }
}

TEST(InterpolatorProgram, AlongOneAxisBothAreTheSame) {
  const Limits limits;
  std::vector<Segment> shared;
  std::vector<Segment> single;
  TimeOptimalProgram(limits, 100.0).Append(Vec3(1, 1, 1), Vec3(1, -3, 1), shared);
  InterpolatorProgram(limits, 100.0).Append(Vec3(1, 1, 1), Vec3(1, -3, 1), single);
  ASSERT_EQ(shared.size(), single.size());
  for (std::size_t i = 0; i < shared.size(); ++i) {
    EXPECT_EQ(shared[i].duration_subticks, single[i].duration_subticks);
    EXPECT_LT((shared[i].end_position_mm - single[i].end_position_mm).norm(), 1e-14);
  }
}

}  // namespace
}  // namespace intaglio::motion
