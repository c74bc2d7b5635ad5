// A stage with a clock of its own, to which a lamp sync that is left out is no tick: what
// the laser fires until that is known is somewhere, and in no journal a point that was
// made.

#include <gmock/gmock.h>

#include <deque>
#include <random>
#include <set>

#include "tests/services/synchronizer/fake_cell.h"

namespace intaglio::synchronizer {
namespace {

using formats::JournalKind;
using formats::PointOutcome;
using testing::IsEmpty;
using namespace std::chrono_literals;

constexpr double kTickNs = 1e9 / FakeLaser::kRateHz;
constexpr std::uint32_t kClockedPoints = 400;

/// The cell with the stamps of its stage, which come some ticks later.
class ClockedCell : public FakeCell {
 public:
  explicit ClockedCell(bool lockstep, double jitter_s = 0.0002)
      : FakeCell({.points = kClockedPoints, .lockstep = lockstep}),
        jitter_ns_(1e9 * jitter_s) {
    clock.Reset(FakeLaser::kRateHz);
    motion_clock = &clock;
    lockstep_ticks_a_step = 2;
    on_tick = [this](std::uint64_t tick) { Stamp(tick); };
  }

  void LeaveOut(std::uint32_t syncs) {
    LeaveOutSyncs(syncs);
    true_ns_ += syncs * kTickNs;
  }
  /// Nothing comes of the stage's stamps.
  bool silent_stamps = false;

  MotionClock clock;

 private:
  void Stamp(std::uint64_t tick) {
    true_ns_ += kTickNs;
    const double jitter = std::uniform_real_distribution<>(0, jitter_ns_)(random_);
    stamps_.emplace_back(tick, static_cast<std::uint64_t>(true_ns_ + jitter));
    for (; stamps_.size() > 4; stamps_.pop_front())
      if (!silent_stamps) clock.Observe(stamps_.front().first, stamps_.front().second);
  }

  double jitter_ns_, true_ns_ = 1e9;
  std::mt19937_64 random_{3};
  std::deque<std::pair<std::uint64_t, std::uint64_t>> stamps_;
};

struct Account {
  std::size_t stray = 0;        ///< cracks that are not at the point of their tick
  std::size_t stray_known = 0;  ///< of which the journal says that their point was made
  std::size_t doubled = 0;      ///< points with two cracks
};

Account AccountOf(const FakeCell& cell) {
  std::map<std::uint64_t, std::uint32_t> intents;
  std::map<std::uint64_t, PointOutcome> outcomes;
  for (const formats::JournalRecord& record : cell.JournalOnDisk().records) {
    if (record.kind == JournalKind::kIntent) intents[record.tick] = record.point;
    if (record.kind == JournalKind::kOutcome) outcomes[record.tick] = record.outcome;
  }
  Account account;
  std::set<double> hit;
  for (const Crack& crack : cell.laser.cracks()) {
    account.doubled += !hit.insert(crack.at_mm.x()).second;
    const Vec3& meant = cell.points_mm.at(intents.at(crack.tick));
    if ((meant - crack.at_mm).norm() < 1e-6) continue;
    ++account.stray;
    account.stray_known += outcomes[crack.tick] != PointOutcome::kUncertain;
  }
  return account;
}

class OwnClock : public testing::TestWithParam<bool> {};

INSTANTIATE_TEST_SUITE_P(Engraving, OwnClock, testing::Bool(), [](const auto& param) {
  return std::string(param.param ? "Lockstep" : "RealTime");
});

TEST_P(OwnClock, EveryPointIsMadeAndNoneIsUncertain) {
  for (const double jitter_s : {0.0, 0.0002, 0.002}) {
    ClockedCell cell(GetParam(), jitter_s);
    cell.Grant();
    ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
    EXPECT_EQ(cell.made(), kClockedPoints) << jitter_s;
    EXPECT_THAT(cell.Disagreements(), IsEmpty());
  }
}

TEST_P(OwnClock, WhatIsFiredUntilALampSyncIsMissedIsUncertain) {
  std::size_t stray = 0;
  for (std::uint32_t syncs = 1; syncs <= 8; ++syncs) {
    ClockedCell cell(GetParam());
    cell.Grant();
    ASSERT_TRUE(cell.StepUntilMade(100 + syncs));
    cell.LeaveOut(syncs);
    ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
    const Account account = AccountOf(cell);
    EXPECT_EQ(account.stray_known, 0u) << syncs;
    EXPECT_EQ(account.doubled, 0u) << syncs;
    EXPECT_GE(cell.Count(PointState::kUncertain), account.stray) << syncs;
    EXPECT_LE(cell.Count(PointState::kUncertain), 24u) << syncs;
    EXPECT_EQ(cell.made() + cell.Count(PointState::kUncertain), kClockedPoints) << syncs;
    stray += account.stray;
  }
  EXPECT_GT(stray, 0u) << "the bench fires none at a wrong place";
}

// Its pulses are known by the laser's counter, and asked about at no later fault.
TEST_P(OwnClock, TheCounterOfTheLaserIsRightBehindPulsesOfUnknownPlace) {
  ClockedCell cell(GetParam());
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(100));
  for (std::uint32_t i = 0; i < 6 && cell.Count(PointState::kUncertain) == 0; ++i) {
    cell.LeaveOut(2 + i % 3);
    cell.StepUntil([&] { return cell.Count(PointState::kUncertain) > 0; }, 100ms);
  }
  ASSERT_GT(cell.Count(PointState::kUncertain), 0u);
  const std::size_t made = cell.laser.cracks().size();
  ASSERT_TRUE(cell.StepUntilMade(made + 10)) << cell.Description();
  cell.CutLine(true);
  cell.StepFor(400ms);
  cell.CutLine(false);
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_THAT(cell.engraving->message(), testing::Not(testing::HasSubstr("counts")));
  EXPECT_EQ(cell.made() + cell.Count(PointState::kUncertain), kClockedPoints);
}

// A person may have them made again.
TEST_P(OwnClock, UncertainPulsesAreFiredAgainByConsentAlone) {
  ClockedCell cell(GetParam());
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(100));
  for (std::uint32_t i = 0; i < 6 && cell.Count(PointState::kUncertain) == 0; ++i) {
    cell.LeaveOut(2 + i % 3);
    cell.StepUntil([&] { return cell.Count(PointState::kUncertain) > 0; }, 100ms);
  }
  ASSERT_GT(cell.Count(PointState::kUncertain), 0u);
  cell.GrantFiringUncertain();
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_EQ(cell.made(), kClockedPoints);
}

// Nobody knows then where the stage was.
TEST_P(OwnClock, PulsesWithoutAStampOfTheStageAreUncertainAndHoldNothingUp) {
  ClockedCell cell(GetParam());
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(100));
  cell.silent_stamps = true;
  ASSERT_TRUE(cell.StepUntilMade(103));
  cell.Withdraw();
  ASSERT_TRUE(
      cell.StepUntil([&] { return cell.phase() == Engraving::Phase::kWaiting; }, 5000ms))
      << cell.Description();
  EXPECT_GE(cell.Count(PointState::kUncertain), 1u);
  EXPECT_EQ(cell.Count(PointState::kArmed), 0u);
  cell.silent_stamps = false;
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilDone()) << cell.Description();
  EXPECT_EQ(cell.made() + cell.Count(PointState::kUncertain), kClockedPoints);
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
}

}  // namespace
}  // namespace intaglio::synchronizer
