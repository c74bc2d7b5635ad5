#include "services/synchronizer/pulses/tick_windows.h"

#include <gmock/gmock.h>

#include "tests/services/synchronizer/laser_bench.h"

namespace intaglio::synchronizer {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using namespace std::chrono_literals;

constexpr std::uint32_t kWindowPoints = 8;

class TickWindowsTest : public testing::TestWithParam<bool> {
 protected:
  TickWindowsTest() {
    bench_.laser.on_arm = [this](std::uint64_t tick) { armed_.push_back(tick); };
  }
  bool Arm(std::uint64_t last) {
    return ticks_.Arm(
        last, [](std::uint32_t) { return 12.0; },
        [this](std::uint32_t point) { late_.push_back(point); });
  }
  void Send() {
    journal_.AwaitDisk();
    ticks_.SendDurable();
    bench_.StepFor(10ms);
  }

  LaserBench bench_{GetParam()};
  JournalBench journal_{kWindowPoints};
  PulseRecord record_{kWindowPoints, true, *journal_.writer, [](const PulseResult&) {}};
  TickWindows ticks_{bench_.controller, record_};
  std::vector<std::uint64_t> armed_;  // as the controller received them
  std::vector<std::uint32_t> late_;
};

INSTANTIATE_TEST_SUITE_P(Pulses, TickWindowsTest, testing::Bool(), [](const auto& param) {
  return std::string(param.param ? "Lockstep" : "RealTime");
});

TEST_P(TickWindowsTest, ArmsExactlyThePlannedTicksAndNoneBeforeItsIntentIsOnDisk) {
  ticks_.Begin(10, false);
  for (const std::uint32_t tick : {12, 15, 21}) ticks_.schedule().Add(tick, tick - 12);
  bench_.laser.on_arm = [this](std::uint64_t tick) {
    armed_.push_back(tick);
    const auto journal = formats::ReadJournal(journal_.file);
    EXPECT_TRUE(std::any_of(journal->records.begin(), journal->records.end(),
                            [&](const auto& record) {
                              return record.kind == formats::JournalKind::kIntent &&
                                     record.tick == tick;
                            }))
        << tick;
  };
  ASSERT_TRUE(Arm(20));
  EXPECT_TRUE(ticks_.holds_windows());
  EXPECT_EQ(ticks_.decided(), 20u);
  EXPECT_EQ(record_.ledger().count(PointState::kArmed), 2u);
  Send();
  EXPECT_FALSE(ticks_.holds_windows());
  EXPECT_THAT(armed_, ElementsAre(12, 15)) << "21 is not decided yet";
}

TEST_P(TickWindowsTest, WithoutRoomForAnIntentNothingIsSent) {
  ticks_.Begin(10, false);
  ticks_.schedule().Add(12, 0);
  journal_.Fill();
  EXPECT_FALSE(Arm(20));
  EXPECT_FALSE(ticks_.holds_windows());
  Send();
  EXPECT_THAT(armed_, IsEmpty());
  const auto never_sent = ticks_.DropUnsent();
  ASSERT_EQ(never_sent.size(), 1u);
  EXPECT_EQ(never_sent[0].point, 0u);
}

TEST_P(TickWindowsTest, APointWhoseTickHasPassedIsLate) {
  ticks_.Begin(10, false);
  ticks_.schedule().Add(12, 0);
  ticks_.schedule().Add(30, 1);
  ticks_.SkipTo(20);
  ASSERT_TRUE(Arm(40));
  Send();
  EXPECT_THAT(late_, ElementsAre(0));
  EXPECT_THAT(armed_, ElementsAre(30));
}

TEST_P(TickWindowsTest, WhatIsHeldIsDroppedAndWhatIsSentIsNot) {
  ticks_.Begin(10, false);
  for (const std::uint32_t tick : {12, 22, 32}) ticks_.schedule().Add(tick, tick / 10);
  ASSERT_TRUE(Arm(20));
  Send();
  ASSERT_TRUE(Arm(30));
  const auto never_sent = ticks_.DropUnsent();
  ASSERT_EQ(never_sent.size(), 1u);
  EXPECT_EQ(never_sent[0].tick, 22u);
  EXPECT_EQ(ticks_.schedule().armed_count(), 2u) << "their results are somebody else's";
  Send();
  EXPECT_THAT(armed_, ElementsAre(12));
}

TEST_P(TickWindowsTest, IdleTicksFireNothingAndAreDecidedOnce) {
  if (!GetParam()) GTEST_SKIP() << "in real time ticks pass by themselves";
  ticks_.SendIdle(100);
  ticks_.SendIdle(100);
  EXPECT_EQ(ticks_.decided(), 100u) << "the first are still to pass";
  bench_.StepFor(10ms);
  int passed = 0;
  for (; passed < 300 && bench_.laser.MayPassTick(); ++passed) bench_.PassTicks(1);
  EXPECT_EQ(passed, 100);
  bench_.StepFor(30ms);
  ticks_.SendIdle(50);
  EXPECT_EQ(ticks_.decided(), 150u);
  bench_.laser.EnterSafeState();
  bench_.StepFor(30ms);
  ticks_.SendIdle(50);
  bench_.StepFor(30ms);
  EXPECT_FALSE(bench_.laser.MayPassTick()) << "none in a safe state";
  EXPECT_THAT(armed_, IsEmpty());
}

TEST_P(TickWindowsTest, AnotherSessionIsNoticedUntilARunBegins) {
  ticks_.Begin(10, false);
  EXPECT_FALSE(ticks_.session_lost());
  bench_.Reconnect();
  EXPECT_TRUE(ticks_.session_lost());
  ticks_.Begin(20, false);
  EXPECT_FALSE(ticks_.session_lost());
}

}  // namespace
}  // namespace intaglio::synchronizer
