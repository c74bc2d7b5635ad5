#include "services/synchronizer/engraving/shutters.h"

#include <gtest/gtest.h>

#include "tests/services/synchronizer/laser_bench.h"

namespace intaglio::synchronizer {
namespace {

using link::LaserFrame;
using namespace std::chrono_literals;

class ShuttersTest : public testing::Test {
 protected:
  /// A run that goes on: every turn asks whether they are open.
  bool IsOpenWithin(std::chrono::milliseconds time) {
    for (const auto end = bench_.now + time; bench_.now < end;) {
      bench_.Step();
      if (shutters_.UpdateSeenOpen()) return true;
    }
    return false;
  }
  bool IsClosedWithin(std::chrono::milliseconds time) {
    for (const auto end = bench_.now + time; bench_.now < end;) {
      bench_.Step();
      if (shutters_.KeepClosed(bench_.now)) return true;
    }
    return false;
  }

  LaserBench bench_;
  Shutters shutters_{bench_.controller};
};

TEST_F(ShuttersTest, BeforeTheFirstRunNoneMayFire) {
  EXPECT_EQ(shutters_.run_mask(), 0);
  EXPECT_FALSE(shutters_.are_open());
  EXPECT_TRUE(shutters_.KeepClosed(bench_.now));
}

TEST_F(ShuttersTest, AreOpenWhenAStatusShowsExactlyThoseOfTheRun) {
  ASSERT_TRUE(shutters_.Open(5, bench_.now));
  EXPECT_FALSE(shutters_.are_open()) << "commanded is not open";
  ASSERT_TRUE(IsOpenWithin(50ms));
  EXPECT_EQ(bench_.laser.shutters(), 5);
  // Another one would let the pulses into another block.
  bench_.laser.stuck_open = 2;
  bench_.StepFor(50ms);
  EXPECT_FALSE(shutters_.are_open());
  EXPECT_TRUE(shutters_.UpdateSeenOpen()) << "so it is a fault and not the travel";
}

TEST_F(ShuttersTest, ThoseOfTheNextRunHaveNotBeenSeenOpen) {
  ASSERT_TRUE(shutters_.Open(1, bench_.now));
  ASSERT_TRUE(IsOpenWithin(50ms));
  ASSERT_TRUE(shutters_.Open(2, bench_.now));
  EXPECT_FALSE(shutters_.UpdateSeenOpen());
}

TEST_F(ShuttersTest, OneThatDoesNotOpenIsNoticedAfterTheTravelTime) {
  bench_.laser.shutter_stuck = true;
  ASSERT_TRUE(shutters_.Open(1, bench_.now));
  EXPECT_FALSE(IsOpenWithin(1990ms));
  EXPECT_FALSE(shutters_.fails_to_open(bench_.now));
  EXPECT_FALSE(IsOpenWithin(20ms));
  EXPECT_TRUE(shutters_.fails_to_open(bench_.now));
}

TEST_F(ShuttersTest, AreCommandedClosedUntilTheyAre) {
  ASSERT_TRUE(shutters_.Open(3, bench_.now));
  ASSERT_TRUE(IsOpenWithin(50ms));
  bench_.laser.stuck_open = 1;
  const std::size_t commands = bench_.ReceivedCount(LaserFrame::kShutterCommand);
  EXPECT_FALSE(IsClosedWithin(1000ms));
  // One in 20 ms, as statuses come.
  EXPECT_NEAR(
      static_cast<double>(bench_.ReceivedCount(LaserFrame::kShutterCommand) - commands),
      50, 2);
  EXPECT_FALSE(shutters_.fails_to_close(bench_.now));
  EXPECT_FALSE(IsClosedWithin(1500ms));
  EXPECT_TRUE(shutters_.fails_to_close(bench_.now));
  bench_.laser.stuck_open = 0;
  EXPECT_TRUE(IsClosedWithin(100ms));
  EXPECT_FALSE(shutters_.fails_to_close(bench_.now));
}

TEST_F(ShuttersTest, WhatTheLineDoesNotTakeIsNoRun) {
  bench_.CutLine(true);
  bench_.StepFor(600ms);
  EXPECT_FALSE(shutters_.Open(1, bench_.now));
  EXPECT_EQ(shutters_.run_mask(), 0);
}

}  // namespace
}  // namespace intaglio::synchronizer
