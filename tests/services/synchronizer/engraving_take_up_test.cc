// A synchronizer that dies at any instant, and another that takes its job up: held
// against the fake glass.

#include <gmock/gmock.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include "tests/services/synchronizer/fake_cell.h"

namespace intaglio::synchronizer {
namespace {

using formats::JournalKind;
using testing::IsEmpty;
using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr std::uint32_t kTakeUpPoints = 120;

std::size_t OffsetOf(std::size_t record) {
  return formats::kJournalHeaderSize + record * formats::kJournalRecordSize;
}

/// Records behind the last intent: outcomes that no arm has waited for, so that a power
/// failure may take any of them.
std::size_t FirstUnconfirmed(const formats::Journal& journal) {
  std::size_t first = journal.records.size();
  while (first > 0 && journal.records[first - 1].kind == JournalKind::kOutcome) --first;
  return first;
}

void Blank(const fs::path& file, std::size_t record) {
  std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
  out.seekp(static_cast<std::streamoff>(OffsetOf(record)));
  const std::vector<char> zeros(formats::kJournalRecordSize, 0);
  out.write(zeros.data(), static_cast<std::streamsize>(zeros.size()));
}

void GoOnToTheEnd(FakeCell& cell) {
  cell.GrantAnew();
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
  EXPECT_EQ(cell.made() + cell.Count(PointState::kUncertain), kTakeUpPoints);
}

class TakeUp : public testing::TestWithParam<bool> {
 protected:
  bool lockstep() const { return GetParam(); }
};

INSTANTIATE_TEST_SUITE_P(Engraving, TakeUp, testing::Bool(), [](const auto& param) {
  return std::string(param.param ? "Lockstep" : "RealTime");
});

TEST_P(TakeUp, AtAnyInstantNothingIsDoubledAndNothingUnknown) {
  int killed_with_armed = 0;
  for (int instant_ms = 1; instant_ms < 900; instant_ms += lockstep() ? 7 : 61) {
    SCOPED_TRACE(testing::Message() << instant_ms << " ms");
    FakeCell cell({.points = kTakeUpPoints, .lockstep = lockstep()});
    cell.Grant();
    cell.StepFor(std::chrono::milliseconds(instant_ms));
    if (cell.done()) break;
    killed_with_armed += cell.Count(PointState::kArmed) > 0 ? 1 : 0;
    cell.DieAndTakeUp();
    GoOnToTheEnd(cell);
    EXPECT_EQ(cell.Count(PointState::kUncertain), 0u);
  }
  EXPECT_GT(killed_with_armed, 0) << "or the test tests nothing";
}

TEST_P(TakeUp, AgainAndAgain) {
  FakeCell cell({.points = kTakeUpPoints, .lockstep = lockstep()});
  for (int life = 0; life < 20 && !cell.done(); ++life) {
    cell.GrantAnew();
    cell.StepFor(std::chrono::milliseconds(lockstep() ? 3 : 60));
    if (life % 2 == 0) cell.StepFor(600ms);
    cell.DieAndTakeUp();
    cell.StepFor(std::chrono::milliseconds(life * 13));
  }
  GoOnToTheEnd(cell);
  EXPECT_EQ(cell.Count(PointState::kUncertain), 0u);
}

// Nothing fires before a person at the machine has armed it again.
TEST_P(TakeUp, WaitsForAPermission) {
  FakeCell cell({.points = kTakeUpPoints, .lockstep = lockstep()});
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(40));
  cell.Withdraw();
  cell.DieAndTakeUp();
  cell.StepFor(500ms);
  const std::size_t cracks = cell.laser.cracks().size();
  cell.StepFor(2000ms);
  EXPECT_EQ(cell.laser.cracks().size(), cracks);
  EXPECT_EQ(cell.made(), cracks);
  EXPECT_TRUE(cell.engraving->waits());
  EXPECT_EQ(cell.laser.shutters(), 0);
  GoOnToTheEnd(cell);
}

TEST_P(TakeUp, AControllerThatWasSwitchedOffLeavesOneWindowUncertain) {
  FakeCell cell({.points = kTakeUpPoints, .lockstep = lockstep()});
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(40));
  const std::uint64_t armed = cell.Count(PointState::kArmed);
  cell.PowerCycle(100ms);
  cell.DieAndTakeUp();
  GoOnToTheEnd(cell);
  EXPECT_LE(cell.Count(PointState::kUncertain), armed);
}

// Whatever a power failure leaves of the records that no arm had waited for, byte by
// byte.
TEST_P(TakeUp, AJournalCutAtAnyByteBehindTheLastIntent) {
  std::size_t cut = 0, last = 1;
  for (std::size_t taken = 0; taken < last; taken += 151) {
    FakeCell cell({.points = kTakeUpPoints, .lockstep = lockstep()});
    cell.Grant();
    ASSERT_TRUE(cell.StepUntilMade(50));
    cell.Withdraw();
    cell.StepFor(400ms);
    cell.DieAndTakeUp([&](const fs::path& file) {
      const std::size_t size = fs::file_size(file);
      last = size - OffsetOf(FirstUnconfirmed(*formats::ReadJournal(file)));
      cut = size - taken;
      fs::resize_file(file, cut);
    });
    SCOPED_TRACE(testing::Message() << "cut at " << cut);
    GoOnToTheEnd(cell);
    EXPECT_EQ(cell.Count(PointState::kUncertain), 0u);
  }
  EXPECT_GT(last, formats::kJournalRecordSize) << "or the test tests nothing";
}

// A disk that had confirmed what it did not have. The controller's counter shows how many
// records are gone, and the order which points they were about: a person is asked, and
// nothing is fired twice.
TEST_P(TakeUp, AJournalWithoutItsLast64KilobytesDoublesNothing) {
  constexpr std::uint32_t kMany = 1300, kMade = 1150;
  constexpr std::size_t kLost = 64 * 1024;
  std::mt19937_64 random(5);
  const std::size_t step = std::getenv("INTAGLIO_LONG") != nullptr ? 1 : 97;
  for (std::size_t records = 0; records * formats::kJournalRecordSize < kLost;
       records += step) {
    FakeCell cell({.points = kMany, .lockstep = lockstep()});
    cell.lockstep_ticks_a_step = 16;
    cell.Grant();
    ASSERT_TRUE(cell.StepUntilMade(kMade));
    cell.Withdraw();
    cell.StepFor(400ms);
    std::uint64_t known = 0;
    cell.DieAndTakeUp([&](const fs::path& file) {
      const std::size_t whole = formats::kJournalRecordSize;
      const std::size_t lost = records * whole + random() % whole;
      ASSERT_GT(fs::file_size(file), kLost + formats::kJournalHeaderSize);
      fs::resize_file(file, fs::file_size(file) - lost);
      for (const auto& point : formats::HistoryOf(*formats::ReadJournal(file))) {
        known += formats::IsFired(point.outcome) || point.open_intent ? 1 : 0;
      }
    });
    SCOPED_TRACE(testing::Message() << records << " records are gone");
    const std::size_t before = cell.laser.cracks().size();
    cell.StepFor(500ms);
    cell.Grant();
    ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
    EXPECT_GE(cell.made(), known);
    EXPECT_EQ(cell.made() + cell.Count(PointState::kUncertain), kMany);
    EXPECT_EQ(cell.Count(PointState::kUncertain), before > known ? before - known : 0);
    std::vector<Vec3> places;
    for (const Crack& crack : cell.laser.cracks()) places.push_back(crack.at_mm);
    std::sort(places.begin(), places.end(),
              [](const Vec3& a, const Vec3& b) { return a.x() < b.x(); });
    for (std::size_t i = 1; i < places.size(); ++i) {
      ASSERT_GT((places[i] - places[i - 1]).norm(), 1e-3) << "a point was fired twice";
    }
  }
}

/// A job of two runs, of whose second one the disk has kept nothing: every point that the
/// journal knows of has its outcome.
void LoseTheSecondRun(FakeCell& cell) {
  cell.lockstep_ticks_a_step = 4;
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(20)) << cell.Description();
  cell.Withdraw();
  cell.StepFor(1s);
  const std::size_t kept = cell.JournalOnDisk().records.size();
  const std::size_t known = cell.laser.cracks().size();
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(known + 20)) << cell.Description();
  cell.Withdraw();
  cell.StepFor(1s);
  ASSERT_EQ(cell.Count(PointState::kArmed), 0u);
  cell.DieAndTakeUp([&](const fs::path& file) { fs::resize_file(file, OffsetOf(kept)); });
  ASSERT_EQ(cell.made(), known);
}

void ExpectNoPointTwice(const FakeCell& cell) {
  std::vector<double> places;
  for (const Crack& crack : cell.laser.cracks()) places.push_back(crack.at_mm.x());
  std::sort(places.begin(), places.end());
  for (std::size_t i = 1; i < places.size(); ++i) {
    ASSERT_GT(places[i] - places[i - 1], 1e-3) << "a point was fired twice";
  }
}

// Nothing is left to be asked of the controller, and yet its counter is compared,
// however late its line comes up: what it counts more is the glass's.
TEST_P(TakeUp, AJournalWithoutItsLastRunDoublesNothing) {
  for (const auto silence : {0ms, 3000ms}) {
    SCOPED_TRACE(silence.count());
    FakeCell cell({.points = kTakeUpPoints, .lockstep = lockstep()});
    LoseTheSecondRun(cell);
    const std::size_t before = cell.laser.cracks().size(), known = cell.made();
    cell.CutLine(true);
    cell.StepFor(silence);
    cell.CutLine(false);
    for (int renewals = 0; renewals < 2; ++renewals) {
      cell.RenewGrant();
      cell.StepFor(2s);
    }
    EXPECT_EQ(cell.laser.cracks().size(), before) << "a person is asked";
    EXPECT_TRUE(cell.engraving->waits());
    EXPECT_TRUE(cell.engraving->faulted());
    EXPECT_FALSE(cell.engraving->lost_a_line());
    EXPECT_THAT(cell.engraving->message(), testing::HasSubstr("check the block"));
    cell.GrantAnew();
    ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
    EXPECT_EQ(cell.Count(PointState::kUncertain), before - known);
    EXPECT_EQ(cell.made() + cell.Count(PointState::kUncertain), kTakeUpPoints);
    ExpectNoPointTwice(cell);
  }
}

// The grant of before comes when all of that is known already: it does not cover it.
TEST_P(TakeUp, AGrantThatComesLateIsSpentByWhatIsFoundAllTheSame) {
  FakeCell cell({.points = kTakeUpPoints, .lockstep = lockstep()});
  LoseTheSecondRun(cell);
  const std::size_t before = cell.laser.cracks().size();
  const Grant grant = std::exchange(cell.grant, {});
  cell.StepFor(3s);
  cell.grant = grant;
  cell.RepeatGrant();
  cell.StepFor(2s);
  EXPECT_EQ(cell.laser.cracks().size(), before);
  EXPECT_TRUE(cell.engraving->faulted());
  EXPECT_THAT(cell.engraving->message(), testing::HasSubstr("check the block"));
  cell.GrantAnew();
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  ExpectNoPointTwice(cell);
}

// As above, in any order; and even outcomes of long ago are in the controller's memory.
TEST_P(TakeUp, AnyOutcomesMayBeMissingInTheJournal) {
  std::mt19937_64 random(3);
  for (int round = 0; round < 12; ++round) {
    FakeCell cell({.points = kTakeUpPoints, .lockstep = lockstep()});
    cell.Grant();
    ASSERT_TRUE(cell.StepUntilMade(60));
    cell.DieAndTakeUp([&](const fs::path& file) {
      const auto records = formats::ReadJournal(file)->records;
      for (std::size_t i = 0; i < records.size(); ++i) {
        if (records[i].kind == JournalKind::kOutcome && random() % 3 == 0) Blank(file, i);
      }
    });
    cell.GrantAnew();
    ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
    EXPECT_EQ(cell.made(), kTakeUpPoints);
    EXPECT_EQ(cell.laser.cracks().size(), kTakeUpPoints) << "round " << round;
  }
}

// Also in a later life they stay left out.
TEST_P(TakeUp, WhatTheOperatorLeavesOutIsNeverFired) {
  FakeCell cell({.points = kTakeUpPoints, .lockstep = lockstep()});
  cell.lockstep_ticks_a_step = 1;
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(20));
  cell.Withdraw();
  cell.StepFor(1000ms);
  const std::uint64_t made = cell.made();
  ASSERT_LT(made, 100u);
  cell.first_point = 100;
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(made + 5));
  cell.DieAndTakeUp();
  cell.first_point = 0;
  cell.GrantAnew();
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
  EXPECT_EQ(cell.Count(PointState::kLeftOut), 100 - made);
  EXPECT_EQ(cell.made(), made + kTakeUpPoints - 100);
}

// More than the journal takes at once: none of them is forgotten by a later life.
TEST_P(TakeUp, NoneOfManyThatAreLeftOutIsForgotten) {
  constexpr std::uint32_t kMany = 150'000;
  FakeCell cell({.points = kMany, .lockstep = lockstep()});
  cell.first_point = kMany - 5;
  cell.Grant();
  const auto two_are_made = [&cell] { return cell.laser.cracks().size() >= 2; };
  // The way to them is long.
  ASSERT_TRUE(cell.StepUntil(two_are_made, 10min)) << cell.Description();
  cell.DieAndTakeUp();
  cell.first_point = 0;
  cell.GrantAnew();
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_EQ(cell.Count(PointState::kLeftOut), kMany - 5);
  EXPECT_EQ(cell.laser.cracks().size(), 5u);
}

TEST_P(TakeUp, TheRunBeginsAtTheFirstPointThatIsNotMade) {
  FakeCell cell({.points = kTakeUpPoints, .lockstep = lockstep()});
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(50));
  cell.Withdraw();
  cell.StepFor(1000ms);
  const std::uint64_t made = cell.made();
  cell.DieAndTakeUp();
  cell.results.clear();
  GoOnToTheEnd(cell);
  ASSERT_EQ(cell.results.size(), kTakeUpPoints - made);
  for (std::size_t i = 0; i < cell.results.size(); ++i) {
    EXPECT_EQ(cell.results[i].point, made + i) << "the order is kept";
  }
}

// A person has reached into the machine, and no process was there to detect it.
TEST(TakenUp, ADoorThatWasOpenedMeanwhileWantsAPerson) {
  FakeCell cell({.points = kTakeUpPoints});
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(20)) << cell.Description();
  ++cell.laser.openings;
  cell.DieAndTakeUp();
  const std::size_t made = cell.laser.cracks().size();
  cell.RenewGrant();
  cell.StepFor(2s);
  EXPECT_EQ(cell.laser.cracks().size(), made);
  EXPECT_THAT(cell.engraving->message(), testing::HasSubstr("was opened"));
  // Another life, before anybody has come, knows no more.
  cell.DieAndTakeUp();
  cell.RenewGrant();
  cell.StepFor(2s);
  EXPECT_EQ(cell.laser.cracks().size(), made);
  GoOnToTheEnd(cell);
  // It is in the journal: it costs one arm only.
  const formats::Journal journal = *formats::ReadJournal(cell.journal_file);
  const auto newest = std::find_if(
      journal.records.rbegin(), journal.records.rend(),
      [](const auto& record) { return record.kind == JournalKind::kSession; });
  EXPECT_EQ(newest->openings, cell.laser.openings);
}

// As one that the job before has left on: whoever holds it for the next job would switch
// it off in mid-job.
TEST(EngravingTakeUp, ALampThatIsOnBeforeTheGrantIsTheJobsBeforeItFires) {
  FakeCell cell;
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(3));
  cell.Withdraw();
  cell.DieAndTakeUp();
  ASSERT_TRUE(cell.StepUntil([&] { return cell.phase() == Engraving::Phase::kWaiting; }));
  ASSERT_TRUE(cell.laser.lamp_on());
  EXPECT_FALSE(cell.engraving->has_lamp());
  const auto before = cell.laser.cracks().size();
  cell.GrantAnew();
  ASSERT_TRUE(cell.StepUntilMade(before + 1)) << cell.Description();
  EXPECT_TRUE(cell.engraving->has_lamp());
  EXPECT_EQ(cell.laser.lamp_switched_on_count(), 1) << "it stays warm";
}

}  // namespace
}  // namespace intaglio::synchronizer
