#include "services/synchronizer/pulses/pulse_record.h"

#include <gmock/gmock.h>

#include "tests/services/synchronizer/laser_bench.h"

namespace intaglio::synchronizer {
namespace {

using formats::JournalKind;
using formats::PointOutcome;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::uint32_t kRecordPoints = 8;

class PulseRecordTest : public testing::Test {
 protected:
  PulseRecord NewRecord(bool photosensor_feedback = true) {
    return PulseRecord(kRecordPoints, photosensor_feedback, *journal_.writer,
                       [this](const PulseResult& r) { results_.push_back(r); });
  }
  std::vector<JournalKind> KindsOnDisk() const {
    std::vector<JournalKind> kinds;
    for (const auto& record : journal_.OnDisk().records) kinds.push_back(record.kind);
    return kinds;
  }

  JournalBench journal_{kRecordPoints};
  std::vector<PulseResult> results_;
};

/// What a later life makes of the journal.
PointState StateIn(const formats::PointHistory& history) {
  if (history.open_intent) return PointState::kArmed;
  switch (history.outcome) {
    case PointOutcome::kNone:
      return PointState::kPlanned;
    case PointOutcome::kMade:
      return PointState::kMade;
    case PointOutcome::kMissed:
      return PointState::kMissed;
    case PointOutcome::kSkipped:
      return PointState::kSkipped;
    case PointOutcome::kUncertain:
      return PointState::kUncertain;
    case PointOutcome::kLeftOut:
      break;
  }
  return PointState::kLeftOut;
}

/// One of each: made, missed, skipped, uncertain by a lost controller, uncertain by lost
/// records, uncertain and reopened, armed, and the first one left out.
void MakeOneOfEach(PulseRecord& record) {
  record.BeginRun();
  ASSERT_TRUE(record.LeaveOutBefore(1));
  const PointOutcome outcomes[] = {PointOutcome::kMade, PointOutcome::kMissed,
                                   PointOutcome::kSkipped, PointOutcome::kUncertain,
                                   PointOutcome::kUncertain};
  for (std::uint32_t point = 1; point <= 5; ++point) {
    ASSERT_TRUE(record.Arm(10 * point, point));
    record.Resolve({10 * point, point, outcomes[point - 1], SkipReason::kNone});
  }
  ASSERT_TRUE(record.KeepConsent(3));
  ASSERT_TRUE(record.Reopen(5, 3));
  ASSERT_TRUE(record.MarkUncertain(6));
  ASSERT_TRUE(record.Arm(70, 7));
}

TEST_F(PulseRecordTest, LedgerJournalAndListenerAgreeOnEveryKindOfChange) {
  PulseRecord record = NewRecord();
  MakeOneOfEach(record);
  const auto history = formats::HistoryOf(journal_.OnDisk());
  ASSERT_EQ(history.size(), kRecordPoints);
  for (std::uint32_t point = 0; point < kRecordPoints; ++point) {
    EXPECT_EQ(StateIn(history[point]), record.ledger().state(point)) << point;
  }
  std::vector<std::pair<std::uint32_t, PointOutcome>> published;
  for (const PulseResult& result : results_) {
    published.emplace_back(result.point, result.outcome);
  }
  EXPECT_THAT(published, ElementsAre(std::pair(0, PointOutcome::kSkipped),
                                     std::pair(1, PointOutcome::kMade),
                                     std::pair(2, PointOutcome::kMissed),
                                     std::pair(3, PointOutcome::kSkipped),
                                     std::pair(4, PointOutcome::kUncertain),
                                     std::pair(5, PointOutcome::kUncertain),
                                     std::pair(6, PointOutcome::kUncertain)));
  EXPECT_EQ(results_.front().reason, SkipReason::kLeftOut);
  EXPECT_EQ(record.fired_ticks().first(), 10u);
  EXPECT_EQ(record.fired_ticks().last(), 20u);
  EXPECT_EQ(record.fired_ticks().count(), 11u);
  EXPECT_EQ(record.fired_point_count(), 2u);
}

TEST_F(PulseRecordTest, TheNextLifeBeginsWithTheSameLedger) {
  PulseRecord record = NewRecord();
  MakeOneOfEach(record);
  const EarlierWork earlier = EarlierWorkOf(journal_.OnDisk());
  PulseRecord next = NewRecord();
  const std::vector<PulseResult> armed = next.TakeUp(earlier);
  for (std::uint32_t point = 0; point < kRecordPoints; ++point) {
    EXPECT_EQ(next.ledger().state(point), record.ledger().state(point)) << point;
  }
  ASSERT_EQ(armed.size(), 1u);
  EXPECT_EQ(armed[0].tick, 70u);
  EXPECT_EQ(armed[0].point, 7u);
  EXPECT_EQ(next.run(), 1u);
  next.BeginRun();
  EXPECT_EQ(next.run(), 3u) << "2 may be on its way, without a record";
  EXPECT_EQ(next.ledger().unknown_count(), 1u) << "it was reopened and is not fired yet";
}

// The history compares the estimate with these.
TEST_F(PulseRecordTest, TheTicksOfAllLivesAndPowerUpsCount) {
  EarlierWork earlier;
  earlier.power_up = 2;
  earlier.points.resize(kRecordPoints);
  for (const auto& [point, power_up, tick] :
       {std::tuple(0, 1, 1000), {3, 1, 1099}, {1, 2, 40}, {2, 2, 49}}) {
    earlier.points[point].outcome = PointOutcome::kMade;
    earlier.points[point].fired_count = 1;
    earlier.points[point].power_up = power_up;
    earlier.points[point].tick = tick;
  }
  PulseRecord record = NewRecord();
  record.TakeUp(earlier);
  EXPECT_EQ(record.fired_ticks().count(), 110u);
  record.BeginRun();
  ASSERT_TRUE(record.Arm(59, 4));
  record.Resolve({59, 4, PointOutcome::kMade, SkipReason::kNone});
  EXPECT_EQ(record.fired_ticks().first(), 40u);
  EXPECT_EQ(record.fired_ticks().count(), 120u);
}

TEST(FiredTicks, BehindAPowerCycleTicksCountAnew) {
  FiredTicks ticks;
  EXPECT_EQ(ticks.count(), 0u);
  ticks.Add(900);
  ticks.Add(999);
  ticks.BeginPowerUp();
  EXPECT_EQ(ticks.count(), 100u);
  ticks.Add(7);
  EXPECT_EQ(ticks.count(), 101u);
  EXPECT_EQ(ticks.last(), 7u);
}

TEST_F(PulseRecordTest, OpenIntentsComeInTheOrderOfTheirTicks) {
  EarlierWork earlier;
  earlier.points.resize(kRecordPoints);
  for (const auto& [point, tick] : {std::pair(2, 9), {0, 7}, {5, 8}}) {
    earlier.points[point].open_intent = true;
    earlier.points[point].tick = tick;
  }
  PulseRecord record = NewRecord();
  std::vector<std::uint32_t> points;
  for (const PulseResult& one : record.TakeUp(earlier)) points.push_back(one.point);
  EXPECT_THAT(points, ElementsAre(0, 5, 2));
}

TEST_F(PulseRecordTest, AFullRingChangesNothingUntilThereIsRoom) {
  PulseRecord record = NewRecord();
  record.BeginRun();
  ASSERT_TRUE(record.Arm(10, 1));
  record.Resolve({10, 1, PointOutcome::kUncertain, SkipReason::kNone});
  results_.clear();
  journal_.Fill();
  EXPECT_FALSE(record.MarkUncertain(2));
  EXPECT_FALSE(record.LeaveOutBefore(4));
  EXPECT_FALSE(record.KeepConsent(1));
  EXPECT_FALSE(record.Reopen(1, 1));
  EXPECT_FALSE(record.is_durable());
  EXPECT_EQ(record.ledger().state(0), PointState::kPlanned);
  EXPECT_EQ(record.ledger().state(1), PointState::kUncertain);
  EXPECT_EQ(record.ledger().state(2), PointState::kPlanned);
  EXPECT_THAT(results_, IsEmpty());
  EXPECT_FALSE(record.Arm(20, 3)) << "its intent is not in the journal: never send it";
  journal_.AwaitDisk();
  EXPECT_TRUE(record.is_durable());
  EXPECT_TRUE(record.LeaveOutBefore(3));
  EXPECT_EQ(record.ledger().count(PointState::kLeftOut), 2u);
}

TEST_F(PulseRecordTest, WithoutAPhotosensorWhatWasFiredCountsAsMade) {
  PulseRecord record = NewRecord(false);
  ASSERT_TRUE(record.Arm(10, 0));
  record.Resolve({10, 0, PointOutcome::kMissed, SkipReason::kNone});
  EXPECT_EQ(record.ledger().state(0), PointState::kMade);
  EXPECT_EQ(results_.at(0).outcome, PointOutcome::kMade);
}

// The controller has counted for others before: 17 pulses, of which 3 were armed by us.
TEST_F(PulseRecordTest, TheAccountAgreesWithTheControllersCounter) {
  LaserBench bench;
  bench.WarmUp();
  ASSERT_TRUE(bench.controller.OpenShutters(1));
  const auto fire = [&bench](int count) {
    const std::uint64_t first = bench.laser.tick() + 1;
    ASSERT_TRUE(bench.controller.Arm({first, true, std::vector<bool>(count, true)}));
    bench.StepFor(std::chrono::milliseconds(10));
    bench.PassTicks(count);
    bench.StepFor(std::chrono::milliseconds(30));
  };
  fire(14);
  PulseRecord record = NewRecord();
  record.TakeCounters(bench.controller);
  EXPECT_EQ(record.known_pulse_count(), 14u);
  EXPECT_EQ(record.power_up(), bench.controller.identity().power_up);
  for (std::uint32_t point = 0; point < 3; ++point) {
    ASSERT_TRUE(record.Arm(100 + point, point));
    record.Resolve({100 + point, point, PointOutcome::kMade, SkipReason::kNone});
  }
  fire(3);
  EXPECT_EQ(bench.controller.status().pulse_count, 17u);
  EXPECT_EQ(record.known_pulse_count(), 17u);
  // It agrees already, and is in the journal: no further record.
  record.TakeCounters(bench.controller);
  const auto kinds = KindsOnDisk();
  EXPECT_EQ(std::count(kinds.begin(), kinds.end(), JournalKind::kSession), 1);
  // A pulse that was not requested: the account begins anew, and later lives receive the
  // new one.
  fire(1);
  EXPECT_NE(record.known_pulse_count(), bench.controller.status().pulse_count);
  record.TakeCounters(bench.controller);
  EXPECT_EQ(record.known_pulse_count(), 18u);
  const EarlierWork earlier = EarlierWorkOf(journal_.OnDisk());
  EXPECT_EQ(earlier.pulses_before_job, 15u);
}

TEST_F(PulseRecordTest, OpeningsAreJournaledOnceAndForgottenAtAnotherPowerUp) {
  LaserBench bench;
  PulseRecord record = NewRecord();
  record.TakeCounters(bench.controller);
  record.AcceptOpenings(bench.controller, 2);
  record.AcceptOpenings(bench.controller, 2);
  EXPECT_THAT(KindsOnDisk(), ElementsAre(JournalKind::kSession, JournalKind::kSession));
  EXPECT_EQ(EarlierWorkOf(journal_.OnDisk()).openings, 2u);
  bench.PowerCycle();
  record.TakeCounters(bench.controller);
  const EarlierWork earlier = EarlierWorkOf(journal_.OnDisk());
  EXPECT_EQ(earlier.openings, 0u);
  EXPECT_EQ(earlier.power_up, 2u);
}

}  // namespace
}  // namespace intaglio::synchronizer
