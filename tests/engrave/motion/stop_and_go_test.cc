#include "engrave/motion/stop_and_go.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "engrave/core/check.h"
#include "engrave/motion/profiles.h"
#include "tests/engrave/motion/stop_and_go_ticks.h"
#include "tests/engrave/motion/verified_motion.h"

namespace intaglio::motion {
namespace {

/// Those that fill their ticks.
constexpr Profile kStretched[] = {Profile::kTriangle, Profile::kTrapezoid,
                                  Profile::kCubic, Profile::kMix};

std::vector<Segment> PlannedSegments(const PointList& points, const Vec3& start,
                                     const Limits& limits, double rate_hz,
                                     Profile profile) {
  StopAndGoPlanner planner(limits, rate_hz, profile, start);
  std::vector<Segment> segments;
  for (std::size_t i = 0; i < points.size(); ++i) {
    planner.Append(points[i], static_cast<std::int32_t>(i), true, segments);
  }
  planner.Finish(segments);
  return segments;
}

std::string Violations(const MotionReport& report) {
  std::string text;
  for (const std::string& line : report.violations) text += line + "\n";
  return text;
}

/// Steps of lengths from far below a tick's reach to the whole work volume.
PointList RandomWalk(std::mt19937_64& random, int count) {
  std::uniform_real_distribution<double> exponent(-4.0, 2.0);
  std::normal_distribution<double> direction;
  PointList points;
  Vec3 at(0, 0, 0);
  for (int i = 0; i < count; ++i) {
    const double length = std::pow(10.0, exponent(random));
    const Vec3 way(direction(random), direction(random), direction(random));
    at = (at + length * way.normalized()).cwiseMax(-170.0).cwiseMin(170.0);
    points.push_back(at);
  }
  return points;
}

class EveryRate : public testing::TestWithParam<double> {};

TEST_P(EveryRate, KeepsToTheLimitsAndPassesEveryPointAtItsTick) {
  const double rate_hz = GetParam();
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> speed(10.0, 1000.0);
  std::uniform_real_distribution<double> acceleration(500.0, 20000.0);
  for (const auto& [profile, name, make] : Profiles()) {
    for (int round = 0; round < 40; ++round) {
      Limits limits;
      for (int axis = 0; axis < 3; ++axis) {
        limits.max_speed_mm_s[axis] = speed(random);
        limits.max_acceleration_mm_s2[axis] = acceleration(random);
      }
      const PointList points = RandomWalk(random, 100);
      const Vec3 start(1, 2, 3);
      const auto segments = PlannedSegments(points, start, limits, rate_hz, profile);
      const MotionReport report =
          VerifyMotion({start, Vec3::Zero()}, segments, points, limits, rate_hz);
      EXPECT_TRUE(report.ok()) << name << "\n" << Violations(report);
      EXPECT_EQ(report.points, points.size());
      EXPECT_EQ(report.ticks,
                StopAndGoTicks(points, start, limits, rate_hz, profile) + 1);
      EXPECT_TRUE(segments.back().program_end);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Rates, EveryRate,
                         testing::Values(1.0, 10.0, 50.0, 100.0, 200.0, 1000.0, 4000.0));

TEST(StopAndGo, TakesTheFewestWholeTicks) {
  std::mt19937_64 random(8);
  const Limits limits;
  for (const Profile profile : kStretched) {
    Vec3 at = Vec3::Zero();
    for (const Vec3& point : RandomWalk(random, 2000)) {
      const double s = (point - at).cwiseAbs().maxCoeff();
      if (s == 0.0) continue;
      const double ticks = 100.0 * MinSeconds(profile, s, AxisLimits{80, 7000});
      // The slack of 1e-9 on one side; the other is exact.
      EXPECT_EQ(StopAndGoTicks({point}, at, limits, 100.0, profile),
                std::max<std::uint64_t>(1, std::ceil(ticks * (1 - 1e-9))));
      at = point;
    }
  }
}

TEST(StopAndGo, MixTakesTheSmoothestThatFits) {
  const Limits limits;
  const auto segments_of = [&](double step_mm) {
    return PlannedSegments({Vec3(step_mm, 0, 0)}, Vec3::Zero(), limits, 100.0,
                           Profile::kMix)
               .size() -
           1;  // without the end
  };
  EXPECT_EQ(segments_of(0.1), 1u);   // 6 s / T^2 = 6000 mm/s^2: a cubic in one tick
  EXPECT_EQ(segments_of(0.15), 2u);  // 9000 for the cubic, 6000 for the triangle
  // 38.9 ms without ticks; in 40 ms the triangle would peak at 110 mm/s.
  EXPECT_EQ(segments_of(2.2), 3u);
}

TEST(StopAndGo, NeverDrivesHarderThanTheTicksAskFor) {
  // A short step stretched over its whole tick, 4 s / T^2 and not the limit.
  const Limits limits;
  const PointList points = {Vec3(0.02, 0, 0)};
  const auto segments =
      PlannedSegments(points, Vec3::Zero(), limits, 100.0, Profile::kTriangle);
  const MotionReport report = VerifyMotion({}, segments, points, limits, 100.0);
  EXPECT_NEAR(report.max_acceleration_mm_s2.x(), 4 * 0.02 / 1e-4, 1e-9);
}

TEST(StopAndGo, HoldsForATickWhereItIs) {
  const Limits limits;
  for (const auto& [profile, name, make] : Profiles()) {
    const PointList points = {Vec3(1, 1, 1), Vec3(1, 1, 1), Vec3(1, 1, 1 + 1e-300)};
    const auto segments = PlannedSegments(points, Vec3(1, 1, 1), limits, 100.0, profile);
    const MotionReport report =
        VerifyMotion({Vec3(1, 1, 1), Vec3::Zero()}, segments, points, limits, 100.0);
    EXPECT_TRUE(report.ok()) << Violations(report);
    EXPECT_EQ(report.ticks, 4u);
    EXPECT_EQ(report.path_mm, 0.0);
  }
}

TEST(StopAndGo, StepsTooLongForOneSegmentAreSplit) {
  // 100 mm at 1 um/s are 1e5 s, more ticks than a segment holds at 1 Hz and above.
  const Limits limits{Vec3::Constant(0.001), Vec3::Constant(1.0)};
  const PointList points = {Vec3(100, 20, 0)};
  for (const auto& [profile, name, make] : Profiles()) {
    const auto segments = PlannedSegments(points, Vec3::Zero(), limits, 4.0, profile);
    EXPECT_GT(segments.size(), 4u);
    const MotionReport report = VerifyMotion({}, segments, points, limits, 4.0);
    EXPECT_TRUE(report.ok()) << Violations(report);
    EXPECT_EQ(report.points, 1u);
  }
}

TEST(StopAndGo, ATrapezoidThatEndsWithinASubtickOfTheTickStillKeepsToTheLimits) {
  // Lengths whose least time is a hair below whole ticks: no room to round t_s.
  const Limits limits;
  for (int n = 3; n < 200; ++n) {
    for (const double hair : {0.0, 1e-13, 1e-10, 1e-7, 1e-5}) {
      const double s = 80.0 * (n / 100.0 * (1 - hair) - 80.0 / 7000.0);
      const PointList points = {Vec3(0, s, 0)};
      const auto segments =
          PlannedSegments(points, Vec3::Zero(), limits, 100.0, Profile::kTrapezoid);
      const MotionReport report = VerifyMotion({}, segments, points, limits, 100.0);
      EXPECT_TRUE(report.ok()) << Violations(report);
      EXPECT_LE(report.ticks, n + 2u);
    }
  }
}

TEST(StopAndGo, KeepsTheLengthsOfTheVectors) {
  std::mt19937_64 random(10);
  Limits limits;
  limits.max_speed_norm_mm_s = 60.0;
  limits.max_acceleration_norm_mm_s2 = 5000.0;
  limits.travel_mm = {Vec3::Constant(-170.0), Vec3::Constant(170.0)};
  const PointList points = RandomWalk(random, 300);
  for (const auto& [profile, name, make] : Profiles()) {
    const auto segments = PlannedSegments(points, Vec3::Zero(), limits, 100.0, profile);
    const MotionReport report = VerifyMotion({}, segments, points, limits, 100.0);
    EXPECT_TRUE(report.ok()) << name << "\n" << Violations(report);
    EXPECT_GT(report.peak_speed_mm_s, 50.0) << name;
    EXPECT_GT(report.peak_acceleration_mm_s2, 4000.0) << name;
  }
}

TEST(StopAndGo, IsTheSameBitForBit) {
  std::mt19937_64 random(9);
  const PointList points = RandomWalk(random, 500);
  const auto first = PlannedSegments(points, Vec3::Zero(), {}, 200.0, Profile::kMix);
  const auto second = PlannedSegments(points, Vec3::Zero(), {}, 200.0, Profile::kMix);
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].end_position_mm, second[i].end_position_mm);
    EXPECT_EQ(first[i].end_velocity_mm_s, second[i].end_velocity_mm_s);
    EXPECT_EQ(first[i].duration_subticks, second[i].duration_subticks);
  }
}

TEST(StopAndGo, RefusesWhatIsNoPlace) {
  StopAndGoPlanner planner({}, 100.0, Profile::kMix, Vec3::Zero());
  std::vector<Segment> out;
  EXPECT_THROW(planner.Append(Vec3(0, std::nan(""), 0), 0, true, out), PreconditionError);
  EXPECT_TRUE(out.empty());
  EXPECT_THROW(StopAndGoPlanner({}, 0.0, Profile::kMix, Vec3::Zero()), PreconditionError);
}

}  // namespace
}  // namespace intaglio::motion
