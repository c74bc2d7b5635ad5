#include "engrave/motion/parabola_program.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "tests/engrave/motion/hermite_velocity.h"
#include "tests/engrave/motion/verified_motion.h"

namespace intaglio::motion {
namespace {

constexpr double kLeapRateHz = 100.0;
struct Leap {
  std::uint64_t ticks = 0;
  std::vector<Segment> segments;
};

Leap LeapOver(const Vec3& from_mm, const Vec3& to_mm, const Limits& limits) {
  Leap leap;
  leap.ticks = ParabolaProgram(limits, kLeapRateHz).Append(from_mm, to_mm, leap.segments);
  leap.segments.back().point = 0;
  leap.segments.back().pulse = true;
  return leap;
}

/// Calls visit(seconds, position, velocity) at samples of the segments.
template <typename Visit>
void EachSample(const Vec3& from_mm, const std::vector<Segment>& segments,
                Visit&& visit) {
  KnotState from{from_mm, Vec3::Zero()};
  double start_s = 0.0;
  for (const Segment& segment : segments) {
    const double duration_s = DurationSeconds(segment.duration_subticks, kLeapRateHz);
    for (int i = 1; i <= 37; ++i) {
      const double t = duration_s * i / 37;
      visit(start_s + t, HermitePosition(from, segment, t, duration_s),
            HermiteVelocity(from, segment, t, duration_s));
    }
    start_s += duration_s;
    from = segment.end();
  }
}

const Vec3 kSteps[] = {{0.05, 0, 0},  {0, 0.3, 0},   {3, 1, 0.5},   {-30, 40, 0},
                       {100, 20, -7}, {0, 0, 2},     {0.01, 0, -5}, {-2, 2, -2},
                       {0, 0, -0.1},  {0.4, 0.3, 12}};

TEST(ParabolaProgram, StaysOnItsParabola) {
  for (const Vec3& step : kSteps) {
    const Vec3 from(1, 2, 3);
    const Leap leap = LeapOver(from, from + step, {});
    const Vec3 arch = ArchOfStep(from, from + step, Limits{}.travel_mm);
    const Vec3 e = step.normalized();
    const Vec3 n = arch.normalized();
    const double b = step.norm() / 2;
    const double h = arch.norm();
    EXPECT_NEAR(e.dot(n), 0.0, 1e-12);
    EXPECT_NEAR(h, std::min(0.1 * step.norm(), 1.0), 1e-12);
    double farthest = 0.0;
    EachSample(from, leap.segments, [&](double, const Vec3& p, const Vec3&) {
      const double x5 = (p - from).dot(e);
      const double x3 = (p - from).dot(n);
      EXPECT_NEAR((p - from).dot(e.cross(n)), 0.0, 1e-12);
      farthest =
          std::max(farthest, std::abs(x3 - (h - h / (b * b) * (x5 - b) * (x5 - b))));
    });
    EXPECT_LT(farthest, 1e-4) << step.transpose();
  }
}

TEST(ParabolaProgram, TheSpeedAlongIsATrapezoid) {
  for (const Vec3& step : kSteps) {
    const Leap leap = LeapOver(Vec3::Zero(), step, {});
    const double tau = static_cast<double>(leap.ticks) / kLeapRateHz;
    double top = 0.0;
    double length = 0.0;
    Vec3 before = Vec3::Zero();
    EachSample(Vec3::Zero(), leap.segments, [&](double, const Vec3& p, const Vec3& v) {
      top = std::max(top, v.norm());
      length += (p - before).norm();
      before = p;
    });
    // (51) solved for the ramp. Of the pieces' speed a per cent is their own.
    const double ramp = tau - length / top;
    EachSample(Vec3::Zero(), leap.segments, [&](double t, const Vec3&, const Vec3& v) {
      const double law = top * std::min({1.0, t / ramp, (tau - t) / ramp});
      EXPECT_NEAR(v.norm(), law, 0.02 * top) << step.transpose();
    });
  }
}

TEST(ParabolaProgram, TheCentripetalAccelerationIsWithinTheLimits) {
  // Across the step there is hardly any force: only slowing down keeps it.
  const Limits limits{Vec3(500, 500, 500), Vec3(7000, 7000, 300)};
  const PointList points = {Vec3(10, 0, 0)};
  const Leap leap = LeapOver(Vec3::Zero(), points[0], limits);
  const MotionReport report =
      VerifyMotion({}, leap.segments, points, limits, kLeapRateHz);
  EXPECT_TRUE(report.ok()) << report.violations[0];
  EXPECT_GT(report.max_acceleration_mm_s2.z(), 200.0);
  // V^2 2k = a_z at the apex, k = 4 h / (2b)^2.
  EXPECT_LT(report.max_speed_mm_s.x(), std::sqrt(300.0 / (8 * 1.0 / 100)) * 1.001);
  EXPECT_GT(leap.ticks, LeapOver(Vec3::Zero(), points[0],
                                 {limits.max_speed_mm_s, Vec3::Constant(7000)})
                            .ticks);
}

TEST(ParabolaProgram, IsHardlySlowerThanTheLine) {
  for (const Vec3& step : kSteps) {
    const Limits limits;
    const double line_s = StopAndGoSeconds(1.0, UnitStepLimits(step, limits));
    const Leap leap = LeapOver(Vec3::Zero(), step, limits);
    // The arc is at most 2.6 % longer, cos theta takes 7 % of the speed across and the
    // centripetal share at most two fifths of the time.
    EXPECT_LE(leap.ticks, WholeTicks(1.4 * line_s, kLeapRateHz)) << step.transpose();
  }
}

TEST(ParabolaProgram, LeapsWhereTheTravelLeavesRoom) {
  Limits limits;
  limits.travel_mm = {Vec3(0, 0, 0), Vec3(100, 100, 50)};
  // Under the ceiling it goes below, between two it is flat.
  EXPECT_GT(ArchOfStep({1, 1, 1}, {11, 1, 1}, limits.travel_mm).z(), 0.9);
  EXPECT_LT(ArchOfStep({1, 1, 50}, {11, 1, 50}, limits.travel_mm).z(), -0.9);
  EXPECT_NEAR(ArchOfStep({1, 1, 49.7}, {4, 1, 0.3}, limits.travel_mm).norm(), 1.0, 1e-9);
  const Box3 slab{Vec3(0, 0, 10), Vec3(100, 100, 10.00001)};
  EXPECT_TRUE(ArchOfStep({1, 1, 10}, {11, 1, 10}, slab).isZero(0.0));
  for (const double z : {0.0, 0.02, 10.0, 49.99, 50.0}) {
    const PointList points = {Vec3(90, 100, z)};
    const Leap leap = LeapOver({10, 0, z}, points[0], limits);
    const MotionReport report = VerifyMotion({Vec3(10, 0, z), Vec3::Zero()},
                                             leap.segments, points, limits, kLeapRateHz);
    EXPECT_TRUE(report.ok()) << report.violations[0];
  }
}

TEST(ParabolaProgram, KeepsTheLengthsOfTheVectors) {
  Limits limits;
  limits.max_speed_norm_mm_s = 60;
  limits.max_acceleration_norm_mm_s2 = 3000;
  const PointList points = {Vec3(20, 20, 3)};
  const Leap leap = LeapOver(Vec3::Zero(), points[0], limits);
  const MotionReport report =
      VerifyMotion({}, leap.segments, points, limits, kLeapRateHz);
  EXPECT_TRUE(report.ok()) << report.violations[0];
  EXPECT_GT(report.peak_speed_mm_s, 50);
}

TEST(ParabolaProgram, RisesAsHighAsItIsAskedTo) {
  const Box3 travel{Vec3::Constant(-100), Vec3::Constant(100)};
  const Vec3 to_mm(10, 0, 0);
  EXPECT_NEAR(ArchOfStep(Vec3::Zero(), to_mm, travel).z(), 1, 1e-12);
  EXPECT_NEAR(ArchOfStep(Vec3::Zero(), to_mm, travel, 0.3).z(), 0.3, 1e-12);
  EXPECT_NEAR(ArchOfStep(Vec3::Zero(), to_mm, travel, 2.5).z(), 2.5, 1e-12);
  EXPECT_NEAR(ArchOfStep(Vec3::Zero(), to_mm, travel, 8).z(), 5, 1e-12) << "half of it";
  EXPECT_EQ(ArchOfStep(Vec3::Zero(), to_mm, travel, 0), Vec3(Vec3::Zero()));
  for (const double height_mm : {0.0, 0.3, 2.5}) {
    std::vector<Segment> segments;
    Limits limits;
    limits.travel_mm = travel;
    ParabolaProgram(limits, 100, height_mm).Append(Vec3::Zero(), to_mm, segments);
    double highest_mm = 0;
    for (const Segment& s : segments)
      highest_mm = std::max(highest_mm, s.end_position_mm.z());
    // The apex lies on a knot or between two.
    EXPECT_LE(highest_mm, height_mm + kMaxDeviationMm);
    EXPECT_GE(highest_mm, 0.8 * height_mm - kMaxDeviationMm);
  }
}

}  // namespace
}  // namespace intaglio::motion
