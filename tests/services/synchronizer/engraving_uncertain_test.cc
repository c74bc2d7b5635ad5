// Uncertain points, of which it is not known whether they were fired, and the person who
// is asked.

#include "tests/services/synchronizer/uncertain_cell.h"

namespace intaglio::synchronizer {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using namespace std::chrono_literals;

INSTANTIATE_TEST_SUITE_P(Engraving, Uncertain, testing::Bool(), [](const auto& param) {
  return std::string(param.param ? "Lockstep" : "RealTime");
});

TEST_P(Uncertain, AreLeftWithoutAQuestionUnlessTheJobAsks) {
  FakeCell cell({.points = kPoints, .lockstep = lockstep()});
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(40));
  cell.CutLineOverForgottenPulses();
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_GT(cell.Count(PointState::kUncertain), 0u);
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
}

TEST_P(Uncertain, AJobThatAsksWaitsForAPerson) {
  FakeCell cell(Asking());
  LeaveSomeUncertain(cell, 40);
  ExpectItWaits(cell);
  LeaveThemAndEnd(cell);
}

TEST_P(Uncertain, TheQuestionReportsHowManyAndWhere) {
  FakeCell cell(Asking());
  LeaveSomeUncertain(cell, 40);
  ExpectItWaits(cell);
  std::uint32_t first = kPoints, last = 0;
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    if (cell.engraving->ledger().state(i) != PointState::kUncertain) continue;
    first = std::min(first, i);
    last = i;
  }
  EXPECT_THAT(
      cell.engraving->message(),
      HasSubstr(": " + std::to_string(cell.Count(PointState::kUncertain)) +
                ", at places " + std::to_string(first) + ".." + std::to_string(last)));
  // The bench's machine frame is that of its glass.
  char place[64];
  std::snprintf(place, sizeof place, "at %.3f, %.3f, %.3f mm", cell.points_mm[first].x(),
                cell.points_mm[first].y(), cell.points_mm[first].z());
  EXPECT_THAT(cell.engraving->message(), HasSubstr(place));
}

TEST_P(Uncertain, WhoeverTakesTheJobUpAsks) {
  FakeCell cell(Asking());
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(40));
  ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kArmed) > 0; }));
  cell.PowerCycle(100ms);
  cell.DieAndTakeUp();
  // The grant of before is the first that comes.
  ExpectItWaits(cell);
  EXPECT_GT(cell.Count(PointState::kUncertain), 0u);
  LeaveThemAndEnd(cell);
}

TEST_P(Uncertain, AnOpenQuestionIsAskedAgainInTheNextLife) {
  FakeCell cell(Asking());
  LeaveSomeUncertain(cell, 40);
  for (int life = 0; life < 3; ++life) {
    ExpectItWaits(cell);
    cell.DieAndTakeUp();
  }
  ExpectItWaits(cell);
  LeaveThemAndEnd(cell);
}

TEST_P(Uncertain, AnAnsweredQuestionIsNot) {
  FakeCell cell(Asking(kMoreThanAWindow));
  LeaveSomeUncertain(cell, 20);
  ExpectItWaits(cell);
  const std::uint64_t uncertain = cell.Count(PointState::kUncertain);
  cell.GrantAnew();
  ASSERT_TRUE(cell.StepUntilMade(cell.laser.cracks().size() + 5)) << cell.Description();
  cell.DieAndTakeUp();
  cell.RenewGrant();
  ASSERT_TRUE(cell.StepUntilMade(cell.laser.cracks().size() + 20)) << cell.Description();
  EXPECT_EQ(cell.Count(PointState::kUncertain), uncertain);
}

// Else the answer would have no use.
TEST_P(Uncertain, AlsoWhenNothingElseIsLeftItAsks) {
  FakeCell cell(Asking(4));
  cell.laser.on_arm = [&cell](std::uint64_t) { cell.PowerCycle(50ms); };
  cell.Grant();
  ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kUncertain) == 4; }))
      << cell.Description();
  cell.laser.on_arm = nullptr;
  ExpectItWaits(cell);
  EXPECT_TRUE(cell.engraving->asks());
  cell.DieAndTakeUp();
  ExpectItWaits(cell);
  // A withdrawn arm is no answer.
  cell.Withdraw();
  ++cell.grant.number;
  cell.StepFor(1s);
  EXPECT_FALSE(cell.done());
  LeaveThemAndEnd(cell);
}

// The arm that was given before anybody knew is no answer either.
TEST_P(Uncertain, AnArmThatCameBeforeTheQuestionIsSpentByIt) {
  FakeCell cell(Asking());
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(40));
  ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kArmed) > 0; }));
  cell.PowerCycle(1s);
  cell.StepFor(600ms);
  cell.Grant();
  ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kUncertain) > 0; }));
  ExpectItWaits(cell);
  LeaveThemAndEnd(cell);
}

TEST_P(Uncertain, ADoorThatIsOpenedMeanwhileDoesNotHideTheQuestion) {
  FakeCell cell(Asking());
  LeaveSomeUncertain(cell, 40);
  cell.StepFor(1s);
  cell.laser.door_closed = false;
  cell.StepFor(100ms);
  cell.GrantAnew();
  cell.StepFor(500ms);
  EXPECT_THAT(cell.engraving->message(), HasSubstr("the door is open"));
  EXPECT_THAT(cell.engraving->message(), HasSubstr("check the block"));
  cell.laser.door_closed = true;
  cell.StepFor(100ms);
  ExpectItWaits(cell);
  LeaveThemAndEnd(cell);
}

}  // namespace
}  // namespace intaglio::synchronizer
