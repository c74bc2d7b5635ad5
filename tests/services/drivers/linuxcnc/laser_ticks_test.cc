#include "services/drivers/linuxcnc/laser_ticks.h"

#include <gtest/gtest.h>

namespace intaglio::drivers {
namespace {

using link::TickOutcome;

struct Bench {
  void Deliver(std::uint64_t newest) {
    ticks.Deliver(
        newest, [this](const auto& report) { reports.push_back(report); },
        [this](const auto& past) { pasts.push_back(past); });
  }
  LaserTicks ticks;
  std::vector<link::PulseReport> reports;
  std::vector<link::PastReport> pasts;
};

TEST(LaserTicks, DecidesEachTickOnce) {
  Bench bench;
  bench.ticks.Begin({});
  bench.ticks.Arm({10, true, {true, false, true}}, 5);
  bench.ticks.Arm({11, false, {true, true, true}}, 5);
  EXPECT_FALSE(bench.ticks.TakeDecision(9).decided);
  EXPECT_TRUE(bench.ticks.TakeDecision(10).fire && bench.ticks.decided_through() == 13);
  EXPECT_FALSE(bench.ticks.TakeDecision(11).fire);
  EXPECT_TRUE(bench.ticks.TakeDecision(12).gated);
  EXPECT_FALSE(bench.ticks.TakeDecision(13).gated);
  bench.Deliver(13);
  ASSERT_EQ(bench.reports.size(), 2u);  // 11 and 12, armed twice
  EXPECT_EQ(bench.reports[0].outcome, std::vector{TickOutcome::kTooLate});
}

TEST(LaserTicks, FiresNothingOfATickWhoseRowsAreSent) {
  Bench bench;
  bench.ticks.Begin({});
  bench.ticks.Arm({10, false, {true, true}}, 10);
  EXPECT_FALSE(bench.ticks.TakeDecision(10).decided);
  EXPECT_TRUE(bench.ticks.TakeDecision(11).fire);
}

TEST(LaserTicks, ForgetsWhatIsDisarmedAndKeepsWhatAnInterlockVoids) {
  Bench bench;
  bench.ticks.Begin({});
  bench.ticks.Arm({10, false, {true, true}}, 0);
  bench.ticks.Disarm(8);
  EXPECT_EQ(bench.ticks.decided_through(), 8u);
  EXPECT_FALSE(bench.ticks.TakeDecision(10).decided);
  bench.ticks.Arm({20, false, {true}}, 10);
  bench.ticks.Interlock();
  const auto voided = bench.ticks.TakeDecision(20);
  EXPECT_TRUE(voided.decided && voided.fire && voided.interlocked);
}

TEST(LaserTicks, ReportsInOrderAndRemembersAcrossSessions) {
  Bench bench;
  bench.ticks.Begin({3, 7});
  bench.ticks.Report(10, TickOutcome::kFiredSeen);
  bench.ticks.Report(11, TickOutcome::kNotArmed);
  bench.ticks.Report(14, TickOutcome::kInterlocked);
  bench.ticks.RequestPast(2, 9);
  bench.Deliver(14);
  ASSERT_EQ(bench.reports.size(), 2u);
  EXPECT_EQ(bench.reports[0].outcome.size(), 2u);
  EXPECT_EQ(bench.reports[1].first_tick, 14u);
  ASSERT_EQ(bench.pasts.size(), 1u);
  for (std::uint64_t tick = 2; tick <= 10; ++tick)
    EXPECT_EQ(bench.pasts[0].outcome[tick - 2] == TickOutcome::kFiredSeen,
              tick == 3 || tick == 7 || tick == 10)
        << tick;
  bench.ticks.RequestPast(5, 1);
  bench.Deliver(5 + link::kRememberedTicks);
  EXPECT_EQ(bench.pasts.back().outcome.front(), TickOutcome::kNoLongerKnown);
}

}  // namespace
}  // namespace intaglio::drivers
