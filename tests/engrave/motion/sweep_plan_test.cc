// Plans whose third axis passes points beside their height (TickPlannerOptions.sweep_mm).
// Judged by MotionVerifier, and here once more from the segments alone.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "engrave/core/check.h"
#include "engrave/motion/planner.h"
#include "engrave/motion/tick_planner.h"
#include "tests/engrave/motion/verified_motion.h"

namespace intaglio::motion::sweep_plan_test {
namespace {

constexpr double kSlabMm = 0.05;

double Unit(std::mt19937_64& random) {
  return std::uniform_real_distribution<double>(0, 1)(random);
}

/// Two fast axes above a slow one.
Limits HeadLimits() {
  Limits limits;
  limits.max_speed_mm_s = {8000, 8000, 50};
  limits.max_acceleration_mm_s2 = {5e7, 5e7, 1000};
  return limits;
}

/// To and fro in slabs, each point at a height of its own.
PointList Slabs(std::size_t count, std::size_t per_slab, std::mt19937_64& random) {
  PointList points;
  for (std::size_t i = 0; i < count; ++i) {
    const auto along = static_cast<double>(i % per_slab);
    const bool back = i / per_slab % 2 == 1;
    points.emplace_back(0.2 * (back ? static_cast<double>(per_slab) - along : along),
                        0.1 * Unit(random),
                        kSlabMm * (static_cast<double>(i / per_slab) + Unit(random)));
  }
  return points;
}

/// The same with jumps across the field and heights without order.
PointList Scatter(std::size_t count, std::mt19937_64& random) {
  PointList points;
  for (std::size_t i = 0; i < count; ++i) {
    points.emplace_back(20 * Unit(random), 20 * Unit(random), Unit(random));
  }
  return points;
}

struct Planned {
  std::vector<Segment> segments;
  PointMoves moves;
};

Planned PlanOf(const PointList& points, const Limits& limits,
               const TickPlannerOptions& options, double rate_hz = 4000) {
  TickPlanner planner(limits, rate_hz, options, {points.front(), Vec3::Zero()});
  Planned planned;
  for (std::size_t i = 0; i < points.size(); ++i) {
    planner.Append(points[i], static_cast<std::int32_t>(i), true, planned.segments);
  }
  planner.Finish(planned.segments);
  planned.moves = planner.moves();
  return planned;
}

MotionReport Verified(const Planned& planned, const PointList& points,
                      const Limits& limits, double tolerance_mm, double rate_hz = 4000) {
  VerifyOptions options;
  options.position_tolerance_mm = tolerance_mm * (1 + 1e-9) + 1e-12;
  return VerifyMotion({points.front(), Vec3::Zero()}, planned.segments, points, limits,
                      rate_hz, options);
}

// A thousand points a slab at 10 kHz: the third axis takes 20 ms from slab to slab, 200
// ticks, so it has to begin that long before the last point of a slab.
TEST(SweepPlan, TheThirdAxisBeginsInTimeAtAnyRate) {
  constexpr double kRateHz = 10'000, kToleranceMm = kSlabMm / 0.85;
  std::mt19937_64 random(5);
  PointList points = Slabs(12'000, 1000, random);
  for (Vec3& point : points) point.x() *= 0.2;
  TickPlannerOptions options = OptionsForRate(kRateHz);
  options.sweep_mm = kToleranceMm;
  const Planned planned = PlanOf(points, HeadLimits(), options, kRateHz);
  for (const Segment& segment : planned.segments) {
    if (segment.point < 0) continue;
    const Vec3 away = segment.end_position_mm - points[segment.point];
    ASSERT_LE(std::abs(away.z()), kToleranceMm * (1 + 1e-9));
  }
  std::uint64_t subticks = 0;
  for (const Segment& segment : planned.segments) subticks += segment.duration_subticks;
  // At the end it goes to the exact height of the last point.
  EXPECT_LT(static_cast<double>(subticks) / kSubticksPerTick,
            1.02 * static_cast<double>(points.size()));
}

TEST(SweepPlan, PassesEachPointInItsPlaceAndWithinTheToleranceOfItsHeight) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 30; ++trial) {
    const PointList points =
        trial % 3 == 0 ? Scatter(150, random) : Slabs(700, 20 + 10 * trial, random);
    Limits limits = HeadLimits();
    // Walls above and below that the way touches.
    if (trial % 4 == 1) limits.travel_mm = {{-1, -1, 0.01}, {60, 60, 1.3}};
    if (trial % 5 == 2) limits.max_jerk_mm_s3 = {1e12, 1e12, 1e7};
    TickPlannerOptions options = OptionsForRate(4000);
    options.window_points = trial % 2 == 0 ? 512 : 90;
    options.look_ahead_points = 40;
    options.sweep_mm = kSlabMm * Unit(random);
    PointList inside = points;
    for (Vec3& point : inside) {
      point = point.cwiseMax(limits.travel_mm.min_mm).cwiseMin(limits.travel_mm.max_mm);
    }
    const Planned planned = PlanOf(inside, limits, options);
    const MotionReport report = Verified(planned, inside, limits, options.sweep_mm);
    ASSERT_TRUE(report.ok()) << trial << ": " << report.violations.front();
    ASSERT_EQ(report.points, inside.size());
    for (const Segment& segment : planned.segments) {
      if (segment.point < 0) continue;
      const Vec3 away = segment.end_position_mm - inside[segment.point];
      ASSERT_EQ(away.x(), 0);
      ASSERT_EQ(away.y(), 0);
      ASSERT_LE(std::abs(away.z()), options.sweep_mm * (1 + 1e-12) + 1e-14);
    }
    EXPECT_LE(planned.moves.max_mm, options.sweep_mm * (1 + 1e-12) + 1e-14);
  }
}

// Without a sweep z has to stop at a height of its own for each point.
TEST(SweepPlan, FiresAtNearlyEveryTickWhereTheMirrorsCan) {
  std::mt19937_64 random(2);
  const PointList points = Slabs(6000, 400, random);
  TickPlannerOptions options = OptionsForRate(4000);
  const Planned still = PlanOf(points, HeadLimits(), options);
  EXPECT_LT(UtilisationRatio(Verified(still, points, HeadLimits(), 0)), 0.06);
  options.sweep_mm = kSlabMm;
  const Planned swept = PlanOf(points, HeadLimits(), options);
  const MotionReport report = Verified(swept, points, HeadLimits(), kSlabMm);
  ASSERT_TRUE(report.ok()) << report.violations.front();
  EXPECT_GT(UtilisationRatio(report), 0.98);
  // z costs the mirrors nothing but its way to the exact height of the last point. The
  // one before is as much as 50 um away in the slab and passed 50 um beside: 100 um from
  // rest to rest at 1000 mm/s^2 are 20 ms or 80 ticks.
  PointList flat = points;
  for (Vec3& point : flat) point.z() = 0;
  const Planned alone = PlanOf(flat, HeadLimits(), OptionsForRate(4000));
  EXPECT_LE(report.ticks, Verified(alone, flat, HeadLimits(), 0).ticks + 80);
}

// An axis that is too slow for the ticks of the others sets the pace.
TEST(SweepPlan, WaitsForASlowAxisAndPassesNoPointBeyondTheTolerance) {
  std::mt19937_64 random(3);
  const PointList points = Slabs(1000, 10, random);
  Limits limits = HeadLimits();
  limits.max_speed_mm_s.z() = 2;
  TickPlannerOptions options = OptionsForRate(4000);
  options.sweep_mm = kSlabMm;
  const Planned planned = PlanOf(points, limits, options);
  const MotionReport report = Verified(planned, points, limits, kSlabMm);
  ASSERT_TRUE(report.ok()) << report.violations.front();
  const double shortest_s = (5 - 2 * kSlabMm) / 2;
  EXPECT_GE(static_cast<double>(report.ticks), 4000 * shortest_s);
  EXPECT_LT(static_cast<double>(report.ticks), 1.1 * 4000 * shortest_s);
}

// What goes on behind a rest begins at the last point: shutters are changed there.
TEST(SweepPlan, EndsInTheExactPlaceOfItsLastPoint) {
  std::mt19937_64 random(4);
  for (const std::size_t count : {1, 2, 30, 513, 900}) {
    const PointList points = Slabs(count, 50, random);
    TickPlannerOptions options = OptionsForRate(4000);
    options.sweep_mm = kSlabMm;
    const Planned planned = PlanOf(points, HeadLimits(), options);
    EXPECT_EQ(planned.segments.back().end_position_mm, points.back()) << count;
    EXPECT_TRUE(planned.segments.back().program_end);
  }
}

TEST(SweepPlan, AddsToTheToleranceOfThePoint) {
  std::mt19937_64 random(5);
  const PointList points = Scatter(400, random);
  PlanOptions options;
  options.limits = HeadLimits();
  options.rate_hz = 4000;
  options.continuous = true;
  options.tolerance_mm = 0.01;
  options.sweep_mm = 0.03;
  const auto planner = MakePlanner(options, points.front());
  Planned planned;
  for (std::size_t i = 0; i < points.size(); ++i) {
    planner->Append(points[i], static_cast<std::int32_t>(i), true, planned.segments);
  }
  planner->Finish(planned.segments);
  ASSERT_TRUE(Verified(planned, points, HeadLimits(), 0.04).ok());
  for (const Segment& segment : planned.segments) {
    if (segment.point < 0) continue;
    const Vec3 away = segment.end_position_mm - points[segment.point];
    ASSERT_LE(away.head<2>().norm(), 0.01 * (1 + 1e-9));
    ASSERT_LE(std::abs(away.z()), 0.04 * (1 + 1e-9));
  }
}

TEST(SweepPlan, RefusesASweepThatIsNone) {
  TickPlannerOptions options;
  options.sweep_mm = -0.01;
  EXPECT_THROW(TickPlanner(HeadLimits(), 4000, options, {}), PreconditionError);
}

}  // namespace
}  // namespace intaglio::motion::sweep_plan_test
