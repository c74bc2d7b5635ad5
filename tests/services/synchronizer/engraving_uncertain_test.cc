// Points of which nobody knows whether they were fired, and the person who is asked.

#include <gmock/gmock.h>

#include <algorithm>

#include "tests/services/synchronizer/fake_cell.h"

namespace intaglio::synchronizer {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using namespace std::chrono_literals;

constexpr std::uint32_t kPoints = 120;
constexpr std::uint32_t kMoreThanAWindow = 3000;  // of a lockstep machine

class Uncertain : public testing::TestWithParam<bool> {
 protected:
  bool lockstep() const { return GetParam(); }
  CellOptions Asking(std::uint32_t points = kPoints) const {
    return {.points = points, .lockstep = lockstep(), .asks_when_uncertain = true};
  }
};

INSTANTIATE_TEST_SUITE_P(Engraving, Uncertain, testing::Bool(), [](const auto& param) {
  return std::string(param.param ? "Lockstep" : "RealTime");
});

/// The controller is switched off over a window of armed points.
void LeaveSomeUncertain(FakeCell& cell, std::uint64_t made) {
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(made)) << cell.Description();
  ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kArmed) > 0; }));
  cell.PowerCycle(100ms);
  ASSERT_TRUE(cell.StepUntil([&] {
    return cell.Count(PointState::kUncertain) > 0 && cell.Count(PointState::kArmed) == 0;
  })) << cell.Description();
}

/// Whatever the job service does by itself: nothing fires.
void ExpectItWaits(FakeCell& cell) {
  const std::size_t cracks = cell.laser.cracks().size();
  cell.StepFor(1s);
  cell.RepeatGrant();
  cell.StepFor(1s);
  cell.RenewGrant();
  cell.StepFor(1s);
  EXPECT_EQ(cell.laser.cracks().size(), cracks);
  EXPECT_EQ(cell.laser.shutters(), 0);
  EXPECT_FALSE(cell.done());
  EXPECT_TRUE(cell.engraving->waits()) << cell.Description();
  EXPECT_TRUE(cell.engraving->faulted());
  EXPECT_FALSE(cell.engraving->lost_a_line()) << "or the job service lets it go on";
  EXPECT_THAT(cell.engraving->message(), HasSubstr("look at the block"));
}

void LeaveThemAndEnd(FakeCell& cell) {
  const std::uint64_t uncertain = cell.Count(PointState::kUncertain);
  cell.GrantAnew();
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
  EXPECT_EQ(cell.Count(PointState::kUncertain), uncertain);
  EXPECT_EQ(cell.made(), cell.points_mm.size() - uncertain);
}

TEST_P(Uncertain, AreLeftWithoutAQuestionUnlessTheJobAsks) {
  FakeCell cell({.points = kPoints, .lockstep = lockstep()});
  LeaveSomeUncertain(cell, 40);
  cell.RenewGrant();
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

TEST_P(Uncertain, TheQuestionSaysHowManyAndWhere) {
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
  // The grant of before is what it hears first.
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
  EXPECT_THAT(cell.engraving->message(), HasSubstr("look at the block"));
  cell.laser.door_closed = true;
  cell.StepFor(100ms);
  ExpectItWaits(cell);
  LeaveThemAndEnd(cell);
}

// ---- The word to fire them ------------------------------------------------------------

std::size_t ReopenedIn(const FakeCell& cell) {
  const auto records = cell.JournalOnDisk().records;
  return static_cast<std::size_t>(std::count_if(
      records.begin(), records.end(),
      [](const auto& record) { return record.kind == formats::JournalKind::kReopened; }));
}

void FireThemAndEnd(FakeCell& cell) {
  const std::uint64_t uncertain = cell.Count(PointState::kUncertain);
  const std::size_t reopened = ReopenedIn(cell);
  cell.GrantFiringUncertain();
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
  EXPECT_EQ(cell.made(), cell.points_mm.size());
  EXPECT_EQ(cell.engraving->ledger().doubted_count(), 0u);
  EXPECT_EQ(ReopenedIn(cell), reopened + uncertain) << "each once";
  EXPECT_LE(cell.laser.cracks().size(), cell.points_mm.size() + reopened + uncertain);
}

TEST_P(Uncertain, APersonsWordMakesEachOnceMore) {
  FakeCell cell(Asking());
  LeaveSomeUncertain(cell, 40);
  ExpectItWaits(cell);
  FireThemAndEnd(cell);
}

TEST_P(Uncertain, TheWordCountsAlsoInAJobThatDoesNotAsk) {
  FakeCell cell({.points = kPoints, .lockstep = lockstep()});
  LeaveSomeUncertain(cell, 40);
  FireThemAndEnd(cell);
}

TEST_P(Uncertain, TheWordCountsWhenNothingElseIsLeft) {
  FakeCell cell(Asking(4));
  cell.laser.on_arm = [&cell](std::uint64_t) { cell.PowerCycle(50ms); };
  cell.Grant();
  ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kUncertain) == 4; }));
  cell.laser.on_arm = nullptr;
  ExpectItWaits(cell);
  FireThemAndEnd(cell);
}

TEST_P(Uncertain, ANewArmWithoutTheWordTakesItBack) {
  FakeCell cell(Asking());
  LeaveSomeUncertain(cell, 40);
  ExpectItWaits(cell);
  // Said, and taken back before the machine let it fire.
  cell.GrantFiringUncertain();
  cell.Withdraw();
  cell.StepFor(500ms);
  LeaveThemAndEnd(cell);
  EXPECT_EQ(ReopenedIn(cell), 0u);
}

// Whoever says it twice in the same arm has said it once, whatever becomes uncertain.
TEST_P(Uncertain, WhatBecomesUncertainLaterIsNotMeant) {
  for (const bool dies : {false, true}) {
    SCOPED_TRACE(dies);
    FakeCell cell({.points = kMoreThanAWindow, .lockstep = lockstep()});
    LeaveSomeUncertain(cell, 20);
    const std::uint64_t before = cell.Count(PointState::kUncertain);
    cell.GrantFiringUncertain();
    ASSERT_TRUE(cell.StepUntilMade(cell.laser.cracks().size() + 5));
    EXPECT_EQ(ReopenedIn(cell), before);
    ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kArmed) > 0; }));
    cell.PowerCycle(100ms);
    if (dies) cell.DieAndTakeUp();
    ASSERT_TRUE(cell.StepUntil([&] {
      return cell.Count(PointState::kUncertain) > 0 &&
             cell.Count(PointState::kArmed) == 0;
    }));
    const std::uint64_t after = cell.Count(PointState::kUncertain);
    cell.RenewGrant();
    ASSERT_TRUE(cell.fire_uncertain);
    ASSERT_TRUE(cell.StepUntilMade(cell.laser.cracks().size() + 20))
        << cell.Description();
    EXPECT_EQ(ReopenedIn(cell), before);
    EXPECT_EQ(cell.Count(PointState::kUncertain), after);
    EXPECT_THAT(cell.Disagreements(), IsEmpty());
  }
}

// There was nothing that it could have meant.
TEST_P(Uncertain, AWordBeforeAnythingIsUncertainIsVoid) {
  for (const bool dies : {false, true}) {
    SCOPED_TRACE(dies);
    FakeCell cell({.points = kMoreThanAWindow, .lockstep = lockstep()});
    cell.Grant();
    cell.fire_uncertain = true;
    ASSERT_TRUE(cell.StepUntilMade(20));
    ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kArmed) > 0; }));
    cell.PowerCycle(100ms);
    if (dies) cell.DieAndTakeUp();
    ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kUncertain) > 0; }));
    const std::uint64_t uncertain = cell.Count(PointState::kUncertain);
    cell.RenewGrant();
    ASSERT_TRUE(cell.StepUntilMade(cell.laser.cracks().size() + 20))
        << cell.Description();
    EXPECT_EQ(cell.Count(PointState::kUncertain), uncertain);
    EXPECT_EQ(ReopenedIn(cell), 0u);
  }
}

TEST_P(Uncertain, WhatLiesBeforeThePlaceToGoOnFromIsNotFired) {
  FakeCell cell(Asking(kMoreThanAWindow));
  LeaveSomeUncertain(cell, 20);
  ExpectItWaits(cell);
  const std::uint64_t uncertain = cell.Count(PointState::kUncertain);
  cell.first_point = kMoreThanAWindow - 5;
  cell.GrantFiringUncertain();
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_EQ(cell.Count(PointState::kUncertain), uncertain);
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
}

// The grant that is heard in the next life is the one that was answered with: nothing of
// it is left but what was open on disk.
TEST_P(Uncertain, KilledAtAnyInstantAfterTheWordNothingIsFiredByItAnew) {
  for (int instant_ms = 0; instant_ms < 700; instant_ms += lockstep() ? 1 : 17) {
    SCOPED_TRACE(testing::Message() << instant_ms << " ms");
    FakeCell cell(Asking());
    LeaveSomeUncertain(cell, 40);
    cell.StepFor(500ms);
    cell.GrantFiringUncertain();
    cell.StepFor(std::chrono::milliseconds(instant_ms));
    if (cell.done()) break;
    cell.DieAndTakeUp();
    const std::size_t reopened = ReopenedIn(cell);
    cell.RenewGrant();
    cell.StepFor(1s);
    EXPECT_EQ(ReopenedIn(cell), reopened);
    EXPECT_THAT(cell.Disagreements(), IsEmpty());
    if (cell.done()) continue;
    cell.GrantFiringUncertain();
    ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
    EXPECT_THAT(cell.Disagreements(), IsEmpty());
    EXPECT_EQ(cell.made(), kPoints);
  }
}

/// As a controller that was switched off again and again would leave it.
void MakeUncertain(const std::filesystem::path& file, std::uint32_t count) {
  auto writer = JournalWriter::Continue(file);
  ASSERT_TRUE(writer) << writer.error().message;
  for (std::uint32_t point = 0; point < count;) {
    const bool kept =
        (*writer)->Append({formats::JournalKind::kIntent, formats::PointOutcome::kNone, 0,
                           1, 10 + point, point, 0}) &&
        (*writer)->Append({formats::JournalKind::kOutcome,
                           formats::PointOutcome::kUncertain, 0, 1, 10 + point, point,
                           0});
    if (kept) ++point;
    while ((*writer)->appended() - (*writer)->durable() > 60'000) (*writer)->Flush();
  }
}

// More than the journal takes at once: whoever dies in between opens no more of them.
TEST_P(Uncertain, OfManyNoneIsOpenedByTheSameWordInAnotherLife) {
  constexpr std::uint32_t kMany = 150'000;
  FakeCell cell({.points = kMany, .lockstep = lockstep()});
  cell.DieAndTakeUp([](const auto& file) { MakeUncertain(file, kMany - 1); });
  ASSERT_EQ(cell.Count(PointState::kUncertain), kMany - 1);
  cell.GrantFiringUncertain();
  ASSERT_TRUE(cell.StepUntil([&] {
    return cell.Count(PointState::kUncertain) < kMany - 1;
  })) << cell.Description();
  const std::uint64_t left = cell.Count(PointState::kUncertain);
  ASSERT_GT(left, 0u) << "or the test tests nothing";
  EXPECT_EQ(cell.engraving->ledger().doubted_count(), kMany - 1 - left);
  cell.DieAndTakeUp();
  EXPECT_EQ(cell.Count(PointState::kUncertain), left);
  EXPECT_EQ(cell.engraving->ledger().doubted_count(), kMany - 1 - left);
  cell.RenewGrant();
  cell.StepFor(1s);
  EXPECT_EQ(cell.Count(PointState::kUncertain), left);
  cell.GrantFiringUncertain();
  EXPECT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kUncertain) == 0; }));
}

}  // namespace
}  // namespace intaglio::synchronizer
