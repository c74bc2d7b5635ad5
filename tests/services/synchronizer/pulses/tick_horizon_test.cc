#include "services/synchronizer/pulses/tick_horizon.h"

#include <gtest/gtest.h>

#include "tests/services/synchronizer/laser_bench.h"

namespace intaglio::synchronizer {
namespace {

using namespace std::chrono_literals;

TEST(TickHorizonTest, InRealTimeItIsASecondOfTheLampAsOurClockMeasuresIt) {
  LaserBench bench;
  TickHorizon horizon(bench.controller, FakeLaser::kRateHz);
  EXPECT_FALSE(horizon.is_settled());
  // The lamp is twice as fast as its nominal rate: 400 ticks in a second of our clock.
  for (int i = 0; i < 1000; ++i) {
    bench.Step();
    if (i % 5 < 2) bench.PassTicks(1);
    horizon.Observe(bench.now);
  }
  EXPECT_TRUE(horizon.is_settled());
  EXPECT_NEAR(static_cast<double>(horizon.AheadTicks()), 404, 12)
      << "statuses come every 20 ms";
  EXPECT_NEAR(static_cast<double>(horizon.WindowTicks()), 202, 6);
  EXPECT_GE(horizon.TickAt(bench.now), bench.controller.status().tick);
  EXPECT_FALSE(horizon.has_own_clock());
}

TEST(TickHorizonTest, InLockstepItDoesNotDependOnOurClock) {
  LaserBench bench(true);
  TickHorizon horizon(bench.controller, FakeLaser::kRateHz);
  EXPECT_TRUE(horizon.is_settled());
  EXPECT_EQ(horizon.AheadTicks(), 4096u);
  EXPECT_EQ(horizon.WindowTicks(), 512u);
  EXPECT_EQ(horizon.IdleTicks(), link::kMaxArmTicks);
  EXPECT_EQ(horizon.TickAt(bench.now + 10s), bench.controller.status().tick);
}

// A second ahead of 200 ticks; never less than 64.
TEST(TickHorizonTest, AStageOnItsOwnClockIsNotPlannedFurtherThanThatIsExtrapolated) {
  LaserBench bench(true);
  MotionClock clock;
  clock.Reset(FakeLaser::kRateHz);
  TickHorizon horizon(bench.controller, FakeLaser::kRateHz);
  horizon.UseMotionClock(&clock);
  EXPECT_TRUE(horizon.has_own_clock());
  EXPECT_EQ(horizon.AheadTicks(), 200u);
  EXPECT_EQ(horizon.IdleTicks(), 200u);
  TickHorizon slow(bench.controller, 10);
  slow.UseMotionClock(&clock);
  EXPECT_EQ(slow.AheadTicks(), 64u);
  horizon.UseMotionClock(nullptr);
  EXPECT_EQ(horizon.AheadTicks(), 4096u);
}

}  // namespace
}  // namespace intaglio::synchronizer
