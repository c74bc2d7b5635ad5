#include "engrave/motion/verify.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engrave/motion/stop_and_go.h"
#include "tests/engrave/motion/verified_motion.h"

namespace intaglio::motion {
namespace {

using testing::Contains;
using testing::HasSubstr;

constexpr double kRateHz = 100.0;

/// A sound plan of three points, to be spoiled.
class Verify : public testing::Test {
 protected:
  Verify() {
    StopAndGoPlanner planner(limits_, kRateHz, Profile::kTriangle, Vec3::Zero());
    for (std::size_t i = 0; i < points_.size(); ++i) {
      planner.Append(points_[i], static_cast<std::int32_t>(i), true, segments_);
    }
    planner.Finish(segments_);
  }

  MotionReport Report() const {
    return VerifyMotion({}, segments_, points_, limits_, kRateHz);
  }

  Limits limits_;
  PointList points_ = {Vec3(0.1, 0, 0), Vec3(0.1, 0.15, 0), Vec3(0.1, 0.15, 0.1)};
  std::vector<Segment> segments_;
};

TEST_F(Verify, SoundPlanHasNoViolation) {
  const MotionReport report = Report();
  EXPECT_TRUE(report.ok());
  EXPECT_EQ(report.points, 3u);
  EXPECT_EQ(report.ticks, 4u);
  EXPECT_EQ(UtilisationRatio(report), 0.75);
  // Triangles over 10 ms: 2 s / T and 4 s / T^2.
  EXPECT_NEAR(report.max_speed_mm_s.y(), 30.0, 1e-9);
  EXPECT_NEAR(report.max_acceleration_mm_s2.y(), 6000.0, 1e-6);
  EXPECT_NEAR(report.peak_acceleration_mm_s2, 6000.0, 1e-6);
  // |a| is 4000, 6000, 4000, 0 mm/s^2 over the four ticks.
  EXPECT_NEAR(report.rms_acceleration_mm_s2, std::sqrt((16e6 + 36e6 + 16e6) / 4), 1e-6);
  // Up, over and down in each; where two axes change over, the jump is the vector's.
  const double jumps =
      4000 + 8000 + std::hypot(4000, 6000) + 12000 + std::hypot(6000, 4000) + 8000 + 4000;
  EXPECT_NEAR(report.mean_jerk_mm_s3, jumps / 0.04, 1e-3);
  EXPECT_NEAR(report.path_mm, 0.35, 1e-12);
}

TEST_F(Verify, FindsSpeedAndAccelerationBeyondTheLimit) {
  limits_.max_speed_mm_s.y() = 29.9;
  limits_.max_acceleration_mm_s2.z() = 3999.0;
  const MotionReport report = Report();
  EXPECT_THAT(report.violations, Contains(HasSubstr("axis 1 reaches 30")));
  EXPECT_THAT(report.violations, Contains(HasSubstr("axis 2 reaches 4000")));
}

TEST_F(Verify, FindsSpeedBeyondTheLimitInsideASegment) {
  // At rest at both ends, too fast in the middle: 1.5 s / T.
  segments_.clear();
  Segment segment;
  segment.end_position_mm = Vec3(0.6, 0, 0);
  segment.duration_subticks = kSubticksPerTick;
  segments_.push_back(segment);
  limits_.max_acceleration_mm_s2.setConstant(1e9);
  points_.clear();
  const MotionReport report = Report();
  EXPECT_THAT(report.violations, Contains(HasSubstr("mm/s, limit 80")));
  EXPECT_NEAR(report.max_speed_mm_s.x(), 90.0, 1e-9);
}

TEST_F(Verify, FindsJerkInsideASegmentAndJumpsOfAcceleration) {
  limits_.max_jerk_mm_s3.x() = 1e9;
  // A triangle's acceleration jumps at its start, its middle and its end.
  const MotionReport jumps = Report();
  EXPECT_THAT(jumps.violations, Contains(HasSubstr("axis 0 jumps by 4000")));
  EXPECT_THAT(jumps.violations, Contains(HasSubstr("axis 0 jumps by 8000")));
  EXPECT_EQ(jumps.violation_count, 3u);

  // One cubic from rest to rest: 6 s / T^2 at its ends, jerk 12 s / T^3.
  segments_.resize(1);
  segments_[0] = {.end_position_mm = Vec3(0.1, 0, 0),
                  .duration_subticks = kSubticksPerTick};
  points_.clear();
  limits_.max_jerk_mm_s3.x() = 1.1e6;
  const MotionReport cubic = Report();
  EXPECT_NEAR(cubic.max_jerk_mm_s3.x(), 1.2e6, 1);
  EXPECT_THAT(cubic.violations, Contains(HasSubstr("mm/s^3, limit 1100000")));
  EXPECT_THAT(cubic.violations, Contains(HasSubstr("jumps by 6000")));
}

TEST_F(Verify, FindsVectorsTooLongThoughEachAxisIsWithinItsLimit) {
  // Both axes are fastest at once, in the middle of the segment: 1.5 s / T.
  segments_.resize(1);
  segments_[0] = {.end_position_mm = Vec3(0.1, 0.1, 0),
                  .duration_subticks = kSubticksPerTick};
  points_.clear();
  limits_.max_speed_norm_mm_s = 21;
  limits_.max_acceleration_norm_mm_s2 = 8400;
  const MotionReport report = Report();
  EXPECT_EQ(report.violation_count, 2u);
  EXPECT_NEAR(report.peak_speed_mm_s, 15 * std::sqrt(2), 1e-9);
  EXPECT_NEAR(report.peak_acceleration_mm_s2, 6000 * std::sqrt(2), 1e-6);
}

TEST_F(Verify, FindsABulgeBeyondTheTravel) {
  // Back at its start after each tick, but away from it in between.
  segments_.resize(2);
  segments_[0] = {.end_velocity_mm_s = Vec3(0, 15, 0),
                  .duration_subticks = kSubticksPerTick};
  segments_[1] = {.end_position_mm = Vec3::Zero(), .duration_subticks = kSubticksPerTick};
  points_.clear();
  limits_.travel_mm = {Vec3(-1, -0.022, 0), Vec3(1, 0.03, 0)};
  const MotionReport report = Report();
  // u^2 (u - 1) v T is minimal at u = 2/3.
  EXPECT_NEAR(report.extent_mm.min_mm.y(), -0.15 * 4 / 27, 1e-12);
  EXPECT_NEAR(report.extent_mm.max_mm.y(), 0.15 * 4 / 27, 1e-12);
  ASSERT_EQ(report.violation_count, 1u);
  EXPECT_THAT(report.violations[0], HasSubstr("segment 0: axis 1 goes from -0.0222"));
}

TEST_F(Verify, FindsAPointOffItsPlace) {
  points_[1].x() += 2e-9;
  const MotionReport report = Report();
  EXPECT_EQ(report.violation_count, 1u);
  EXPECT_EQ(report.points, 2u);
}

TEST_F(Verify, FindsAPointOffItsTick) {
  segments_[1].duration_subticks -= 1;
  EXPECT_THAT(Report().violations, Contains(HasSubstr("not at a whole tick")));
}

TEST_F(Verify, FindsMissingAndDoubledPoints) {
  segments_[3].point = 0;
  const MotionReport report = Report();
  EXPECT_THAT(report.violations, Contains(HasSubstr("point 0 again")));
  EXPECT_THAT(report.violations, Contains(HasSubstr("1 of 3 points is never reached")));
}

TEST_F(Verify, FindsPointsThatDoNotExist) {
  segments_[3].point = 3;
  EXPECT_THAT(Report().violations, Contains(HasSubstr("there is no point 3")));
}

TEST_F(Verify, FindsAnEndInMotion) {
  segments_.pop_back();
  segments_.back().end_velocity_mm_s = Vec3(1, 0, 0);
  segments_.back().program_end = true;
  const MotionReport report = Report();
  EXPECT_THAT(report.violations, Contains(HasSubstr("does not end at rest")));
  EXPECT_THAT(report.violations, Contains(HasSubstr("ends the program in motion")));
}

TEST_F(Verify, FindsAnEndBeforeTheEnd) {
  segments_[1].program_end = true;
  EXPECT_THAT(Report().violations, Contains(HasSubstr("but others follow")));
}

TEST_F(Verify, FindsSegmentsWithoutDuration) {
  segments_[2].duration_subticks = 0;
  EXPECT_THAT(Report().violations, Contains(HasSubstr("has no duration")));
}

TEST_F(Verify, ListsTheFirstTwentyAndCountsAll) {
  limits_.max_speed_mm_s.setConstant(1e-3);
  PointList many;
  StopAndGoPlanner planner({}, kRateHz, Profile::kMix, Vec3::Zero());
  segments_.clear();
  for (int i = 0; i < 50; ++i) {
    many.emplace_back(0.05 * (i + 1), 0, 0);
    planner.Append(many.back(), i, true, segments_);
  }
  points_ = many;
  const MotionReport report = Report();
  EXPECT_EQ(report.violations.size(), 20u);
  EXPECT_EQ(report.violation_count, 50u);
}

}  // namespace
}  // namespace intaglio::motion
