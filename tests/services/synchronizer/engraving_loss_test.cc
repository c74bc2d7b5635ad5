// Points that were armed when the line to the laser controller was lost, or its power.

#include <gmock/gmock.h>

#include <set>

#include "tests/services/synchronizer/fake_cell.h"

namespace intaglio::synchronizer {
namespace {

using testing::IsEmpty;
using namespace std::chrono_literals;
using Phase = Engraving::Phase;

class EngravingLoss : public testing::Test {
 protected:
  void MakeAndLoseTheLine(std::uint64_t count) {
    cell_.Grant();
    ASSERT_TRUE(cell_.StepUntilMade(count));
    cell_.CutLine(true);
  }

  /// The line is back and every armed point has its end.
  void RestoreAndSettle() {
    cell_.CutLine(false);
    ASSERT_TRUE(cell_.StepUntil([this] { return cell_.Count(PointState::kArmed) == 0; }));
    EXPECT_THAT(cell_.Disagreements(), IsEmpty());
  }

  void GoOnAndLoseTheLineAfter(std::size_t points) {
    cell_.GrantAnew();
    const std::size_t before = cell_.laser.cracks().size();
    ASSERT_TRUE(cell_.StepUntilMade(before + points));
    cell_.CutLine(true);
    cell_.StepFor(1000ms);
    RestoreAndSettle();
  }

  void GoOnToTheEnd() {
    cell_.GrantAnew();
    ASSERT_TRUE(cell_.StepUntilDone()) << cell_.engraving->message();
    EXPECT_THAT(cell_.Disagreements(), IsEmpty());
    EXPECT_EQ(cell_.made() + cell_.Count(PointState::kUncertain), cell_.points_mm.size());
  }

  FakeCell cell_{{.points = 160}};
};

TEST_F(EngravingLoss, TheControllerReportsPulsesFiredWhileTheLineWasDown) {
  MakeAndLoseTheLine(40);
  const std::uint64_t known = cell_.made();
  cell_.StepFor(1000ms);
  EXPECT_GT(cell_.laser.cracks().size(), known);  // or the test tests nothing
  EXPECT_GT(cell_.Count(PointState::kArmed), 0);
  RestoreAndSettle();
  EXPECT_EQ(cell_.made(), cell_.laser.cracks().size());
  EXPECT_EQ(cell_.engraving->settled_by_memory_count(), cell_.made() - known);
  EXPECT_EQ(cell_.Count(PointState::kUncertain), 0);
  GoOnToTheEnd();
  EXPECT_EQ(cell_.made(), 160);
}

TEST_F(EngravingLoss, TheControllerReportsThatNothingFiredWhileTheLineWasDown) {
  MakeAndLoseTheLine(40);
  cell_.laser.EnterSafeState();
  cell_.StepFor(1000ms);
  RestoreAndSettle();
  EXPECT_EQ(cell_.made(), cell_.laser.cracks().size());
  EXPECT_EQ(cell_.Count(PointState::kUncertain), 0);
  GoOnToTheEnd();
  EXPECT_EQ(cell_.made(), 160);
}

// Some of the armed ticks found the stage elsewhere: a count could not show which.
TEST_F(EngravingLoss, TheControllerReportsWhichOfTheArmedTicksFired) {
  MakeAndLoseTheLine(40);
  cell_.StepFor(20ms);
  cell_.stage.behind = true;
  cell_.StepFor(60ms);
  cell_.stage.behind = false;
  cell_.StepFor(1000ms);
  RestoreAndSettle();
  EXPECT_EQ(cell_.Count(PointState::kUncertain), 0);
  EXPECT_EQ(cell_.made(), cell_.laser.cracks().size());
  GoOnToTheEnd();
}

TEST_F(EngravingLoss, WhatTheControllerHasForgottenIsUncertainAndUntouched) {
  cell_.laser.forgets = true;
  MakeAndLoseTheLine(40);
  cell_.StepFor(20ms);
  cell_.stage.behind = true;
  cell_.StepFor(60ms);
  cell_.stage.behind = false;
  cell_.StepFor(1000ms);
  const std::size_t fired = cell_.laser.cracks().size();
  RestoreAndSettle();
  EXPECT_GT(cell_.Count(PointState::kUncertain), 0);
  const std::uint64_t uncertain = cell_.Count(PointState::kUncertain);
  EXPECT_GE(cell_.made() + uncertain, fired);
  GoOnToTheEnd();
  EXPECT_EQ(cell_.Count(PointState::kUncertain), uncertain);
}

// Pulses of uncertain points are in the controller's count for good. Taken for pulses of
// the next loss they would make points "made" that never fired.
TEST_F(EngravingLoss, OldUncertainPulsesAreNotCountedAgain) {
  cell_.laser.forgets = true;
  MakeAndLoseTheLine(20);
  cell_.StepFor(20ms);
  cell_.stage.behind = true;
  cell_.StepFor(60ms);
  cell_.stage.behind = false;
  cell_.StepFor(1000ms);
  RestoreAndSettle();
  const std::uint64_t uncertain = cell_.Count(PointState::kUncertain);
  ASSERT_GT(uncertain, 0);
  cell_.laser.forgets = false;
  GoOnAndLoseTheLineAfter(20);
  EXPECT_EQ(cell_.Count(PointState::kUncertain), uncertain);
  GoOnToTheEnd();
}

TEST_F(EngravingLoss, ALineLostThreeTimesIsSettledThreeTimes) {
  cell_.Grant();
  for (int i = 1; i <= 3; ++i) {
    ASSERT_TRUE(cell_.StepUntilMade(40 * i));
    cell_.CutLine(true);
    cell_.StepFor(1000ms);
    RestoreAndSettle();
    cell_.GrantAnew();
  }
  GoOnToTheEnd();
  EXPECT_EQ(cell_.made(), 160);
}

// Shorter than anybody's patience: the link repeats what was lost.
TEST_F(EngravingLoss, AShortGapIsNobodysBusiness) {
  MakeAndLoseTheLine(40);
  cell_.StepFor(100ms);
  cell_.CutLine(false);
  ASSERT_TRUE(cell_.StepUntilDone());
  EXPECT_EQ(cell_.made(), 160);
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());
}

TEST_F(EngravingLoss, AnotherPowerUpLeavesArmedPointsUncertainAndNeverFiresThemAgain) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(40));
  cell_.PowerCycle(800ms);
  ASSERT_TRUE(
      cell_.StepUntil([this] { return cell_.Count(PointState::kUncertain) > 0; }));
  const std::uint64_t uncertain = cell_.Count(PointState::kUncertain);
  EXPECT_EQ(cell_.Count(PointState::kArmed), 0);
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());
  // Nothing lights again before a greater grant.
  cell_.StepFor(1000ms);
  EXPECT_FALSE(cell_.laser.lamp_on());
  EXPECT_TRUE(cell_.engraving->faulted());
  EXPECT_FALSE(cell_.engraving->message().empty());
  GoOnToTheEnd();
  EXPECT_EQ(cell_.Count(PointState::kUncertain), uncertain);
  EXPECT_EQ(cell_.made(), 160 - uncertain);
}

// The job service renews the arm after a lost line, again and again. A laser that was
// switched off meanwhile may have another block below it.
TEST_F(EngravingLoss, APowerCycleCostsTheArmHoweverShortItWas) {
  for (const auto off : {50ms, 300ms, 800ms, 20000ms, 40000ms}) {
    SCOPED_TRACE(testing::Message() << "off for " << off.count() << " ms");
    FakeCell cell({.points = 160});
    cell.Grant();
    ASSERT_TRUE(cell.StepUntilMade(40));
    cell.PowerCycle(off);
    cell.StepFor(off + 1000ms);
    const std::size_t made = cell.laser.cracks().size();
    cell.StepFor(120s);
    EXPECT_EQ(cell.laser.cracks().size(), made);
    EXPECT_FALSE(cell.permission_granted) << "the job service has taken it back";
    EXPECT_TRUE(cell.engraving->waits());
    EXPECT_FALSE(cell.engraving->lost_a_line()) << "it is not renewed";
    EXPECT_THAT(cell.engraving->message(), testing::HasSubstr("controller was s"))
        << "switched off and on, or silent";
    cell.GrantAnew();
    ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
    EXPECT_THAT(cell.Disagreements(), IsEmpty());
  }
}

// Between two lives of the synchronizer, too.
TEST_F(EngravingLoss, APowerCycleThatNobodySawCostsTheArm) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(40));
  cell_.PowerCycle(100ms);
  cell_.DieAndTakeUp();
  cell_.StepFor(1000ms);
  const std::size_t made = cell_.laser.cracks().size();
  cell_.StepFor(60s);
  EXPECT_EQ(cell_.laser.cracks().size(), made);
  EXPECT_THAT(cell_.engraving->message(), testing::HasSubstr("switched off and on"));
  GoOnToTheEnd();
}

// The cable was out, the laser on all the time, and its door was never opened.
TEST_F(EngravingLoss, ALineThatWasDownForLongerThanTheLimitCostsTheArm) {
  for (const auto& [down, goes_on] : {std::pair{25s, true}, {35s, false}}) {
    SCOPED_TRACE(testing::Message() << down.count() << " s");
    FakeCell cell({.points = 160});
    cell.Grant();
    ASSERT_TRUE(cell.StepUntilMade(40));
    cell.CutLine(true);
    cell.StepFor(down);
    cell.CutLine(false);
    cell.StepFor(1000ms);
    const std::size_t made = cell.laser.cracks().size();
    cell.StepFor(60s);
    EXPECT_EQ(cell.done(), goes_on) << cell.Description();
    if (goes_on) continue;
    EXPECT_EQ(cell.laser.cracks().size(), made);
    EXPECT_THAT(cell.engraving->message(), testing::HasSubstr("more than 30 s"));
    cell.GrantAnew();
    ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
    EXPECT_THAT(cell.Disagreements(), IsEmpty());
  }
}

TEST_F(EngravingLoss, AMotionControllerThatWasAwayForLongerThanTheLimitCostsTheArm) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(40));
  cell_.stage.silent = true;
  cell_.StepFor(35s);
  cell_.stage.silent = false;
  cell_.StepFor(1000ms);
  const std::size_t made = cell_.laser.cracks().size();
  cell_.StepFor(60s);
  EXPECT_EQ(cell_.laser.cracks().size(), made);
  EXPECT_THAT(cell_.engraving->message(), testing::HasSubstr("motion controller"));
  GoOnToTheEnd();
}

TEST_F(EngravingLoss, AfterAnotherPowerUpTheNewCounterCounts) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(40));
  cell_.PowerCycle(800ms);
  ASSERT_TRUE(
      cell_.StepUntil([this] { return cell_.Count(PointState::kUncertain) > 0; }));
  const std::uint64_t uncertain = cell_.Count(PointState::kUncertain);
  GoOnAndLoseTheLineAfter(30);
  EXPECT_EQ(cell_.Count(PointState::kUncertain), uncertain);
  GoOnToTheEnd();
}

TEST_F(EngravingLoss, PowerLostWhilePausedCostsNothing) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(40));
  cell_.Withdraw();
  cell_.StepFor(500ms);
  cell_.PowerCycle(2000ms);
  cell_.StepFor(3000ms);
  GoOnToTheEnd();
  EXPECT_EQ(cell_.made(), 160);
}

TEST_F(EngravingLoss, WhoStopsDoesNotWaitForALineThatNeverComesBack) {
  MakeAndLoseTheLine(40);
  cell_.StepFor(500ms);
  cell_.engraving->Stop("the job was cancelled");
  ASSERT_TRUE(cell_.StepUntilDone());
  EXPECT_GT(cell_.Count(PointState::kArmed), 0);
  // The synchronizer that takes the job up when the line is back learns the result of
  // each.
  cell_.CutLine(false);
  cell_.DieAndTakeUp();
  ASSERT_TRUE(cell_.StepUntil([this] { return cell_.Count(PointState::kArmed) == 0; }));
  EXPECT_EQ(cell_.Count(PointState::kUncertain), 0);
  EXPECT_EQ(cell_.made(), cell_.laser.cracks().size());
  EXPECT_THAT(cell_.Disagreements(), IsEmpty());
  // No host is left to close the shutters: the controller does.
  EXPECT_EQ(cell_.laser.shutters(), 0);
}

}  // namespace
}  // namespace intaglio::synchronizer
