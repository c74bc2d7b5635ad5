#include "services/synchronizer/engraving/settling.h"

#include <gmock/gmock.h>

#include "tests/services/synchronizer/laser_bench.h"

namespace intaglio::synchronizer {
namespace {

using testing::HasSubstr;
using namespace std::chrono_literals;

constexpr std::uint32_t kSettlingPoints = 12;

/// A run of which some ticks are armed at a fake controller: what it fired is the oracle.
class SettlingTest : public testing::Test {
 protected:
  SettlingTest() {
    bench_.WarmUp();
    (void)bench_.controller.OpenShutters(1);
    bench_.StepFor(30ms);
    record_.TakeCounters(bench_.controller);
    record_.BeginRun();
    ticks_.Begin(bench_.laser.tick(), false);
  }
  /// Point i at the i-th tick from now.
  void Arm(std::uint32_t count) {
    const std::uint64_t before = bench_.laser.tick();
    for (std::uint32_t i = 0; i < count; ++i) ticks_.schedule().Add(before + 1 + i, i);
    ASSERT_TRUE(ticks_.Arm(
        before + count, [](std::uint32_t) { return 12.0; }, [](std::uint32_t) {}));
  }
  void Send() {
    journal_.AwaitDisk();
    ticks_.SendDurable();
    bench_.StepFor(5ms);
  }
  void Turn() {
    bench_.Step();
    for (const auto& report : bench_.reports) ticks_.Receive(report);
    for (const auto& report : bench_.pasts) settling_.Receive(report);
    bench_.reports.clear();
    bench_.pasts.clear();
    settling_.TakeDisarmed();
    if (auto finding = settling_.Turn(bench_.now, grant_known_, no_run_yet_)) {
      findings_.push_back(*finding);
    }
  }
  void TurnFor(std::chrono::milliseconds time) {
    for (const auto end = bench_.now + time; bench_.now < end;) Turn();
  }
  std::uint64_t Count(PointState state) const { return record_.ledger().count(state); }

  LaserBench bench_;
  JournalBench journal_{kSettlingPoints};
  std::vector<PulseResult> results_;
  PulseRecord record_{kSettlingPoints, true, *journal_.writer,
                      [this](const PulseResult& r) { results_.push_back(r); }};
  TickWindows ticks_{bench_.controller, record_};
  std::vector<std::uint32_t> aborted_runs_;
  MotionFeed feed_{[this](const intaglio_MotionSegmentBatch& batch) -> Status {
                     if (batch.abort) aborted_runs_.push_back(batch.run);
                     return {};
                   },
                   [](const std::string&) { return bus::CreditBook::Grant{}; }};
  Settling settling_{bench_.controller, feed_, ticks_, record_};
  bool grant_known_ = true, no_run_yet_ = false;
  std::vector<std::string> findings_;
};

TEST_F(SettlingTest, WhatIsTakenBackInTimeIsSkippedAndNeverFires) {
  Arm(5);
  Send();
  settling_.Begin(SkipReason::kInterlock, bench_.now);
  EXPECT_FALSE(settling_.disarmed());
  EXPECT_EQ(Count(PointState::kArmed), 5u) << "before the controller has answered";
  TurnFor(60ms);
  EXPECT_TRUE(settling_.disarmed());
  EXPECT_TRUE(settling_.all_settled());
  EXPECT_EQ(Count(PointState::kSkipped), 5u);
  ASSERT_EQ(results_.size(), 5u);
  EXPECT_EQ(results_[0].reason, SkipReason::kInterlock);
  EXPECT_EQ(bench_.laser.shutters(), 0);
  EXPECT_EQ(aborted_runs_.size(), 1u) << "the stage brakes";
  bench_.PassTicks(10);
  EXPECT_TRUE(bench_.laser.cracks().empty());
}

TEST_F(SettlingTest, WhatHadFiredBeforeIsMade) {
  Arm(5);
  Send();
  bench_.PassTicks(2);
  settling_.Begin(SkipReason::kNoPermission, bench_.now);
  TurnFor(60ms);
  EXPECT_EQ(Count(PointState::kMade), 2u);
  EXPECT_EQ(bench_.laser.cracks().size(), 2u);
  EXPECT_EQ(Count(PointState::kSkipped), 3u);
  EXPECT_TRUE(settling_.all_settled());
}

TEST_F(SettlingTest, WhatWasNeverSentIsSkippedAtOnceWhateverTheLine) {
  Arm(3);
  bench_.CutLine(true);
  settling_.Begin(SkipReason::kLink, bench_.now);
  EXPECT_EQ(Count(PointState::kSkipped), 3u);
  EXPECT_TRUE(settling_.all_settled());
  EXPECT_FALSE(settling_.disarmed());
}

TEST_F(SettlingTest, WhatALostLineHidIsReadFromTheControllersMemory) {
  Arm(4);
  Send();
  bench_.CutLine(true);
  bench_.PassTicks(2);
  settling_.Begin(SkipReason::kLink, bench_.now);
  TurnFor(1000ms);
  EXPECT_EQ(Count(PointState::kArmed), 4u) << "nobody can know yet";
  bench_.CutLine(false);
  TurnFor(1000ms);
  EXPECT_TRUE(settling_.disarmed());
  EXPECT_EQ(bench_.laser.cracks().size(), 2u);
  EXPECT_EQ(Count(PointState::kMade), 2u);
  EXPECT_EQ(Count(PointState::kSkipped), 2u);
  EXPECT_EQ(settling_.settled_by_memory_count(), 2u);
  EXPECT_TRUE(findings_.empty()) << "the counter agrees";
}

TEST_F(SettlingTest, WhatTheControllerHasForgottenIsUncertain) {
  Arm(4);
  Send();
  bench_.laser.forgets = true;
  bench_.CutLine(true);
  bench_.PassTicks(4);
  settling_.Begin(SkipReason::kLink, bench_.now);
  TurnFor(600ms);
  bench_.CutLine(false);
  TurnFor(1000ms);
  EXPECT_EQ(Count(PointState::kUncertain), 4u);
  EXPECT_TRUE(settling_.all_settled());
  EXPECT_TRUE(findings_.empty()) << "what the counter has more is explained by them";
}

TEST_F(SettlingTest, AfterAnotherPowerUpNobodyKnows) {
  Arm(4);
  Send();
  bench_.PowerCycle();
  bench_.reports.clear();
  settling_.Begin(SkipReason::kLink, bench_.now);
  TurnFor(100ms);
  EXPECT_EQ(Count(PointState::kUncertain), 4u);
  EXPECT_EQ(record_.power_up(), 2u);
  EXPECT_TRUE(findings_.empty());
}

TEST_F(SettlingTest, AnAnswerBeforeTheDisarmIsConfirmedMeansNothing) {
  Arm(2);
  Send();
  settling_.Begin(SkipReason::kLink, bench_.now);
  settling_.Receive(
      link::PastReport{bench_.laser.tick() + 1,
                       {link::TickOutcome::kNotArmed, link::TickOutcome::kNotArmed}});
  EXPECT_EQ(Count(PointState::kArmed), 2u) << "they may fire yet";
}

TEST_F(SettlingTest, PulsesThatNobodyAskedForAreFoundOnceAGrantIsKnown) {
  const std::uint64_t first = bench_.laser.tick() + 1;
  ASSERT_TRUE(bench_.controller.Arm({first, true, {true, true}}));
  bench_.StepFor(10ms);
  bench_.PassTicks(2);
  bench_.Reconnect();
  bench_.reports.clear();
  grant_known_ = false;
  settling_.Begin(SkipReason::kLink, bench_.now);
  TurnFor(100ms);
  EXPECT_TRUE(findings_.empty()) << "there is no grant that it could cost";
  grant_known_ = true;
  TurnFor(100ms);
  ASSERT_EQ(findings_.size(), 1u) << "once";
  EXPECT_THAT(findings_[0], HasSubstr("counts 2 pulses where 0 are known:"));
  EXPECT_EQ(Count(PointState::kUncertain), 0u) << "no record of ours is missing";
  EXPECT_EQ(record_.known_pulse_count(), 2u);
}

// A journal without its end: the controller fired three for the life before.
TEST_F(SettlingTest, OfALifeWhoseRecordsAreLostTheNextPointsAreUncertain) {
  const std::uint64_t first = bench_.laser.tick() + 1;
  ASSERT_TRUE(bench_.controller.Arm({first, true, {true, true, true}}));
  bench_.StepFor(10ms);
  bench_.PassTicks(3);
  bench_.Reconnect();
  bench_.reports.clear();
  EarlierWork earlier;
  earlier.points.resize(kSettlingPoints);
  earlier.points[0].outcome = formats::PointOutcome::kLeftOut;
  earlier.power_up = bench_.controller.identity().power_up;
  settling_.BeginTakenUp(earlier);
  no_run_yet_ = true;
  TurnFor(100ms);
  ASSERT_EQ(findings_.size(), 1u);
  EXPECT_THAT(findings_[0], HasSubstr("the next 3 points are uncertain"));
  EXPECT_EQ(Count(PointState::kUncertain), 3u);
  EXPECT_EQ(record_.ledger().NextOpen(0), 4u);
  EXPECT_TRUE(settling_.all_settled());
}

TEST_F(SettlingTest, WhatAnEarlierLifeArmedIsAskedOfTheSamePowerUpAlone) {
  Arm(3);
  Send();
  bench_.PassTicks(3);
  bench_.Reconnect();
  bench_.reports.clear();
  EarlierWork earlier = EarlierWorkOf(journal_.OnDisk());
  ASSERT_TRUE(earlier.points.at(2).open_intent);
  earlier.points[2].power_up += 1;
  std::vector<PulseResult> results;
  PulseRecord record(kSettlingPoints, true, *journal_.writer,
                     [&](const PulseResult& r) { results.push_back(r); });
  TickWindows ticks(bench_.controller, record);
  Settling next(bench_.controller, feed_, ticks, record);
  next.BeginTakenUp(earlier);
  EXPECT_EQ(record.ledger().state(2), PointState::kUncertain);
  EXPECT_EQ(record.ledger().count(PointState::kArmed), 2u);
  for (int i = 0; i < 200; ++i) {
    bench_.Step();
    for (const auto& report : bench_.pasts) next.Receive(report);
    bench_.pasts.clear();
    next.TakeDisarmed();
    (void)next.Turn(bench_.now, true, true);
  }
  EXPECT_EQ(record.ledger().count(PointState::kMade), 2u);
  EXPECT_EQ(next.settled_by_memory_count(), 2u);
}

TEST_F(SettlingTest, ADisarmThatTheLineDidNotTakeIsSentAgain) {
  bench_.CutLine(true);
  bench_.StepFor(600ms);
  settling_.Begin(SkipReason::kLink, bench_.now);
  EXPECT_TRUE(settling_.AwaitsDisarm());
  const std::size_t disarms = bench_.ReceivedCount(link::LaserFrame::kDisarm);
  bench_.CutLine(false);
  TurnFor(600ms);
  EXPECT_EQ(bench_.ReceivedCount(link::LaserFrame::kDisarm), disarms + 1);
  EXPECT_TRUE(settling_.disarmed());
  EXPECT_FALSE(settling_.AwaitsDisarm());
}

TEST_F(SettlingTest, IsLateAfterTwoSeconds) {
  EXPECT_FALSE(settling_.is_late(bench_.now + 10s)) << "it has not begun";
  settling_.Begin(SkipReason::kLink, bench_.now);
  EXPECT_FALSE(settling_.is_late(bench_.now + 2s));
  EXPECT_TRUE(settling_.is_late(bench_.now + 2001ms));
}

TEST_F(SettlingTest, AStageThatMovesForAnEarlierLifeIsBraked) {
  MotionView motion;
  motion.highest_run = 7;
  settling_.AbortEarlierRun(motion, bench_.now);
  EXPECT_TRUE(aborted_runs_.empty()) << "nothing is known of it";
  motion.fresh = true;
  for (int i = 0; i < 400; ++i) settling_.AbortEarlierRun(motion, bench_.now += 1ms);
  EXPECT_EQ(aborted_runs_, (std::vector<std::uint32_t>{7, 7})) << "each 200 ms";
  EXPECT_EQ(record_.run(), 7u) << "the next run has a number of its own";
  motion.at_rest = true;
  settling_.AbortEarlierRun(motion, bench_.now += 1s);
  EXPECT_EQ(aborted_runs_.size(), 2u);
}

}  // namespace
}  // namespace intaglio::synchronizer
