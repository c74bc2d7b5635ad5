#include "services/synchronizer/engraving/progress_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace intaglio::synchronizer {
namespace {

using ::testing::HasSubstr;

constexpr double kRateHz = 100;

/// A plan that makes a point in every `ticks_per_point`-th tick.
std::vector<std::uint32_t> Plan(std::size_t points, double ticks_per_point) {
  std::vector<std::uint32_t> ticks;
  for (std::size_t i = 0; i < points; ++i)
    ticks.push_back(static_cast<std::uint32_t>(
        std::llround(static_cast<double>(i + 1) * ticks_per_point)));
  return ticks;
}

/// An engraving whose points come when the test lets them.
class Work {
 public:
  Work(std::size_t points, double ticks_per_point) : watch_(kRateHz) {
    watch_.SetPlan(Plan(points, ticks_per_point));
    sight_.works = true;
    sight_.tick = 1000;
  }
  /// Works for `seconds` at so many points a second, a turn every 50 ms.
  void For(double seconds, double points_a_second) {
    for (double at_s = 0; at_s < seconds; at_s += kTurnS) {
      sight_.tick += static_cast<std::uint64_t>(kTurnS * kRateHz);
      if (!sight_.works) points_a_second = 0;
      made_ += points_a_second * kTurnS;
      sight_.made_count = static_cast<std::uint64_t>(made_);
      sight_.ended_count =
          left_out_ + sight_.made_count + sight_.disturbances.missed_count;
      watch_.Update(sight_);
    }
  }
  void LeaveOut(std::uint64_t count) { sight_.left_out_count = left_out_ += count; }
  bool stalled() const { return watch_.stall().has_value(); }
  const Stall& stall() const { return *watch_.stall(); }
  WorkSight& sight() { return sight_; }

 private:
  static constexpr double kTurnS = 0.05;
  ProgressWatch watch_;
  WorkSight sight_;
  double made_ = 0;
  std::uint64_t left_out_ = 0;
};

TEST(ProgressWatch, RaisesNothingAtThePlannedRate) {
  Work work(20000, 1);
  work.For(120, 100);
  EXPECT_FALSE(work.stalled());
}

// The case of a machine whose tolerance is smaller than its profile's.
TEST(ProgressWatch, RaisesWhenFarFewerPointsComeThanPlanned) {
  Work work(20000, 1);
  work.For(29, 0.7);
  EXPECT_FALSE(work.stalled()) << "not before half a minute of work";
  work.For(3, 0.7);
  ASSERT_TRUE(work.stalled());
  EXPECT_NEAR(work.stall().working_s, 30, 2);
  EXPECT_NEAR(static_cast<double>(work.stall().made_count), 21, 2);
  EXPECT_NEAR(static_cast<double>(work.stall().expected_count), 2400, 160);
}

TEST(ProgressWatch, SlowButPlannedMotionRaisesNothing) {
  // A point every 10 s, by long ways, and one of them comes late.
  Work slow(100, 1000);
  slow.For(600, 0.1);
  EXPECT_FALSE(slow.stalled());
  // 10 % speed: the plan of the full speed would expect ten times as much.
  Work override_(20000, 4);
  override_.sight().speed_percent = 10;
  override_.For(120, 2.5);
  EXPECT_FALSE(override_.stalled());
}

TEST(ProgressWatch, RaisesWhenASlowPlanIsNotKept) {
  Work work(100, 1000);
  work.For(60, 0);
  EXPECT_FALSE(work.stalled()) << "too few points are expected to judge";
  work.For(90, 0);
  EXPECT_TRUE(work.stalled()) << "ten points were expected";
}

TEST(ProgressWatch, TimeInWhichItDoesNotWorkIsNotCounted) {
  Work work(20000, 1);
  work.For(10, 0);
  work.sight().works = false;  // a person pauses it, or the lamp warms up
  work.For(600, 0);
  work.sight().works = true;
  work.For(15, 0);
  EXPECT_FALSE(work.stalled()) << "25 s of work";
  work.For(8, 0);
  EXPECT_TRUE(work.stalled());
}

// In lockstep no tick passes while the machine waits for its host.
TEST(ProgressWatch, TimeWithoutTicksIsNotCounted) {
  Work work(20000, 1);
  for (int turn = 0; turn < 100000; ++turn) work.For(0, 0);
  EXPECT_FALSE(work.stalled());
}

TEST(ProgressWatch, ALineThatIsLostAgainAndAgainIsWork) {
  Work work(20000, 1);
  for (int loss = 0; loss < 40; ++loss) {
    const std::uint64_t tick = work.sight().tick;
    work.sight().tick = 0;
    work.For(0.05, 0);
    ++work.sight().disturbances.line_loss_count;
    work.sight().tick = tick + 100;
    work.For(0.05, 0);
  }
  ASSERT_TRUE(work.stalled());
  EXPECT_THAT(TextOf(work.stall(), ""), HasSubstr("times a line was lost"));
  EXPECT_THAT(TextOf(work.stall(), ""), HasSubstr("check the cables"));
}

TEST(ProgressWatch, EndsWhenThePointsComeAgain) {
  Work work(20000, 1);
  work.For(40, 0);
  ASSERT_TRUE(work.stalled());
  work.For(20, 100);
  EXPECT_FALSE(work.stalled());
}

TEST(ProgressWatch, TheLastPointsRaiseWhenTheyDoNotCome) {
  Work work(3, 10);
  work.For(40, 0);
  EXPECT_TRUE(work.stalled());
}

// `resume --from`: thousands of points are over at once, and none of them was made.
TEST(ProgressWatch, APlaceThatAPersonLeavesOutIsNotExpected) {
  Work work(20000, 1);
  work.For(20, 100);
  work.LeaveOut(10000);
  work.For(40, 100);
  EXPECT_FALSE(work.stalled());
}

TEST(ProgressWatch, AnotherPowerUpOfTheLaserIsNoTime) {
  Work work(20000, 1);
  work.For(10, 0);
  work.sight().tick = 5;
  work.For(15, 0);
  EXPECT_FALSE(work.stalled());
}

TEST(ProgressWatch, ItsTextBeginsWithTheMainCause) {
  Work work(20000, 1);
  work.For(1, 0);
  work.sight().disturbances = {.out_of_position_count = 25,
                               .late_count = 1,
                               .other_skips_count = 0,
                               .missed_count = 2,
                               .line_loss_count = 0,
                               .run_count = 26};
  work.For(31, 0.7);
  ASSERT_TRUE(work.stalled());
  const std::string alone = TextOf(work.stall(), "");
  EXPECT_THAT(alone, HasSubstr("no progress: 2"));
  EXPECT_THAT(alone, HasSubstr("25 pulses were held back because the stage was outside"));
  EXPECT_THAT(alone, HasSubstr("the run began 26 times"));
  EXPECT_THAT(alone, HasSubstr("compare the tolerance of the stage controller"));
  const std::string mismatch = "the controller has 10 um and the profile 30 um";
  EXPECT_THAT(TextOf(work.stall(), mismatch), HasSubstr(mismatch));
  work.sight().disturbances.missed_count = 500;
  work.For(31, 0);
  EXPECT_THAT(TextOf(work.stall(), ""), HasSubstr("check lens, block, pulse energy"));
}

TEST(ProgressWatch, ItsFiguresStayForAWhile) {
  Work work(20000, 1);
  work.For(33, 0.7);
  ASSERT_TRUE(work.stalled());
  const double first = work.stall().working_s;
  const auto made = work.stall().made_count;
  work.For(2, 0.7);
  EXPECT_EQ(work.stall().working_s, first);
  EXPECT_EQ(work.stall().made_count, made);
}

}  // namespace
}  // namespace intaglio::synchronizer
