// A person's consent to fire uncertain points again.

#include "tests/services/synchronizer/uncertain_cell.h"

namespace intaglio::synchronizer {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using namespace std::chrono_literals;

class UncertainConsent : public Uncertain {};

INSTANTIATE_TEST_SUITE_P(Engraving, UncertainConsent, testing::Bool(),
                         [](const auto& param) {
                           return std::string(param.param ? "Lockstep" : "RealTime");
                         });

TEST_P(UncertainConsent, APersonsConsentMakesEachOnceMore) {
  FakeCell cell(Asking());
  LeaveSomeUncertain(cell, 40);
  ExpectItWaits(cell);
  FireThemAndEnd(cell);
}

// A subscriber gets what became of each in the end.
TEST_P(UncertainConsent, WhatIsFiredByItIsPublishedAnew) {
  FakeCell cell({.points = kPoints, .lockstep = lockstep()});
  LeaveSomeUncertain(cell, 40);
  FireThemAndEnd(cell);
  std::map<std::uint32_t, std::vector<formats::PointOutcome>> published;
  for (const PulseResult& result : cell.results) {
    if (result.outcome == formats::PointOutcome::kSkipped) continue;
    published[result.point].push_back(result.outcome);
  }
  ASSERT_EQ(published.size(), kPoints);
  std::size_t twice = 0;
  for (const auto& [point, outcomes] : published) {
    EXPECT_EQ(outcomes.back(), formats::PointOutcome::kMade) << point;
    if (outcomes.size() == 1) continue;
    ++twice;
    EXPECT_THAT(outcomes, testing::ElementsAre(formats::PointOutcome::kUncertain,
                                               formats::PointOutcome::kMade));
  }
  EXPECT_EQ(twice, ReopenedIn(cell));
}

TEST_P(UncertainConsent, TheConsentCountsAlsoInAJobThatDoesNotAsk) {
  FakeCell cell({.points = kPoints, .lockstep = lockstep()});
  LeaveSomeUncertain(cell, 40);
  FireThemAndEnd(cell);
}

TEST_P(UncertainConsent, TheConsentCountsWhenNothingElseIsLeft) {
  FakeCell cell(Asking(4));
  cell.laser.on_arm = [&cell](std::uint64_t) { cell.PowerCycle(50ms); };
  cell.Grant();
  ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kUncertain) == 4; }));
  cell.laser.on_arm = nullptr;
  ExpectItWaits(cell);
  FireThemAndEnd(cell);
}

TEST_P(UncertainConsent, ANewArmWithoutConsentTakesItBack) {
  FakeCell cell(Asking());
  LeaveSomeUncertain(cell, 40);
  ExpectItWaits(cell);
  // Given, and taken back before the machine let it fire.
  cell.GrantFiringUncertain();
  cell.Withdraw();
  cell.StepFor(500ms);
  LeaveThemAndEnd(cell);
  EXPECT_EQ(ReopenedIn(cell), 0u);
}

// Given twice in the same arm it counts once, whatever becomes uncertain.
TEST_P(UncertainConsent, WhatBecomesUncertainLaterIsNotMeant) {
  for (const bool dies : {false, true}) {
    SCOPED_TRACE(dies);
    FakeCell cell({.points = kMoreThanAWindow, .lockstep = lockstep()});
    LeaveSomeUncertain(cell, 20);
    const std::uint64_t before = cell.Count(PointState::kUncertain);
    cell.GrantFiringUncertain();
    ASSERT_TRUE(cell.StepUntilMade(cell.laser.cracks().size() + 5));
    EXPECT_EQ(ReopenedIn(cell), before);
    ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kArmed) > 0; }));
    if (dies) cell.DieAndTakeUp();
    cell.CutLineOverForgottenPulses();
    const std::uint64_t after = cell.Count(PointState::kUncertain);
    ASSERT_GT(after, 0u);
    ASSERT_TRUE(cell.fire_uncertain);
    ASSERT_TRUE(cell.StepUntilMade(cell.laser.cracks().size() + 20))
        << cell.Description();
    EXPECT_EQ(ReopenedIn(cell), before);
    EXPECT_EQ(cell.Count(PointState::kUncertain), after);
    EXPECT_THAT(cell.Disagreements(), IsEmpty());
  }
}

// Who gives it at a machine that has lost its laser means what was under the beam then.
TEST_P(UncertainConsent, ItHoldsForWhatIsStillBeingSettledWhenItIsGiven) {
  for (const bool asks : {false, true}) {
    SCOPED_TRACE(asks);
    FakeCell cell(
        {.points = kPoints, .lockstep = lockstep(), .asks_when_uncertain = asks});
    LeaveSomeUnsettled(cell, 40);
    FireUncertainAtOnce(cell);
    // As the job service does while the line is down.
    cell.RenewGrant();
    ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kUncertain) > 0; }));
    const std::uint64_t uncertain = cell.Count(PointState::kUncertain);
    EXPECT_EQ(ReopenedIn(cell), 0u) << "nothing before the machine may fire";
    ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
    EXPECT_THAT(cell.Disagreements(), IsEmpty());
    EXPECT_EQ(cell.made(), kPoints);
    EXPECT_EQ(ReopenedIn(cell), uncertain) << "each once";
  }
}

TEST_P(UncertainConsent, WhatIsSettledOtherwiseItDoesNotTouch) {
  FakeCell cell(Asking(kMoreThanAWindow));
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(20));
  ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kArmed) > 0; }));
  // Given while the armed ones are taken back: the controller knows of all of them.
  cell.GrantFiringUncertain();
  const std::uint64_t armed = cell.Count(PointState::kArmed);
  ASSERT_TRUE(cell.StepUntilMade(cell.laser.cracks().size() + 5)) << cell.Description();
  EXPECT_EQ(ReopenedIn(cell), 0u);
  // Armed again by a run of that grant, they are not meant any more.
  ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kArmed) >= armed; }));
  cell.PowerCycle(100ms);
  ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kUncertain) > 0; }));
  ExpectItWaits(cell);
  EXPECT_EQ(ReopenedIn(cell), 0u);
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
}

// A run that goes on arms more, and by the same grant: those it cannot mean.
TEST_P(UncertainConsent, ConsentThatComesInARunIsNotAboutWhatIsArmed) {
  FakeCell cell({.points = kMoreThanAWindow, .lockstep = lockstep()});
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(20));
  ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kArmed) > 0; }));
  ++cell.grant.number;
  cell.fire_uncertain = true;
  cell.Step();
  ASSERT_EQ(cell.phase(), Engraving::Phase::kRunning);
  cell.CutLineOverForgottenPulses();
  const std::uint64_t uncertain = cell.Count(PointState::kUncertain);
  ASSERT_GT(uncertain, 0u);
  ASSERT_TRUE(cell.StepUntilMade(cell.laser.cracks().size() + 20)) << cell.Description();
  EXPECT_EQ(cell.Count(PointState::kUncertain), uncertain);
  EXPECT_EQ(ReopenedIn(cell), 0u);
}

// What spends the grant takes the consent with it: then the question is still to be
// asked.
TEST_P(UncertainConsent, ConsentWhoseGrantIsSpentBeforeItIsUsedAnswersNothing) {
  FakeCell cell(Asking());
  LeaveSomeUnsettled(cell, 40);
  FireUncertainAtOnce(cell);
  ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kUncertain) > 0; }));
  cell.laser.door_closed = false;
  cell.StepFor(500ms);
  EXPECT_THAT(cell.engraving->message(), HasSubstr("check the block"));
  cell.laser.door_closed = true;
  cell.StepFor(100ms);
  ExpectItWaits(cell);
  LeaveThemAndEnd(cell);
  EXPECT_EQ(ReopenedIn(cell), 0u);
}

// A life that ends takes its consent with it, whatever was settled: the next one asks.
TEST_P(UncertainConsent, ConsentOfAnEarlierLifeDoesNotCoverWhatIsUnsettled) {
  FakeCell cell(Asking());
  LeaveSomeUnsettled(cell, 40);
  cell.CutLine(true);
  FireUncertainAtOnce(cell);
  cell.StepFor(100ms);
  cell.DieAndTakeUp();
  cell.CutLine(false);
  ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kUncertain) > 0; }));
  ExpectItWaits(cell);
  EXPECT_EQ(ReopenedIn(cell), 0u);
  FireThemAndEnd(cell);
}

// There was nothing that it could have meant.
TEST_P(UncertainConsent, ConsentBeforeAnythingIsUncertainIsVoid) {
  for (const bool dies : {false, true}) {
    SCOPED_TRACE(dies);
    FakeCell cell({.points = kMoreThanAWindow, .lockstep = lockstep()});
    cell.Grant();
    cell.fire_uncertain = true;
    ASSERT_TRUE(cell.StepUntilMade(20));
    ASSERT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kArmed) > 0; }));
    if (dies) cell.DieAndTakeUp();
    cell.CutLineOverForgottenPulses();
    const std::uint64_t uncertain = cell.Count(PointState::kUncertain);
    ASSERT_GT(uncertain, 0u);
    ASSERT_TRUE(cell.StepUntilMade(cell.laser.cracks().size() + 20))
        << cell.Description();
    EXPECT_EQ(cell.Count(PointState::kUncertain), uncertain);
    EXPECT_EQ(ReopenedIn(cell), 0u);
  }
}

TEST_P(UncertainConsent, WhatLiesBeforeThePlaceToGoOnFromIsNotFired) {
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

// The grant that comes to the next life is the one that was answered with: nothing of
// it is left but what was open on disk.
TEST_P(UncertainConsent, KilledAtAnyInstantAfterConsentNothingIsFiredByItAnew) {
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
    // What no life has taken by then is taken by the next one.
    const bool taken = RecordsIn(cell, formats::JournalKind::kConsent) > 0;
    const std::size_t to_open = taken ? 0 : cell.Count(PointState::kUncertain);
    cell.RenewGrant();
    cell.StepFor(1s);
    EXPECT_EQ(ReopenedIn(cell), reopened + to_open);
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

// More than the journal takes at once: a life that ends in between opens no more of them.
TEST_P(UncertainConsent, OfManyNoneIsOpenedByTheSameConsentInAnotherLife) {
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
  EXPECT_EQ(cell.engraving->ledger().unknown_count(), kMany - 1 - left);
  cell.DieAndTakeUp();
  EXPECT_EQ(cell.Count(PointState::kUncertain), left);
  EXPECT_EQ(cell.engraving->ledger().unknown_count(), kMany - 1 - left);
  cell.RenewGrant();
  cell.StepFor(1s);
  EXPECT_EQ(cell.Count(PointState::kUncertain), left);
  cell.GrantFiringUncertain();
  EXPECT_TRUE(cell.StepUntil([&] { return cell.Count(PointState::kUncertain) == 0; }));
}

}  // namespace
}  // namespace intaglio::synchronizer
