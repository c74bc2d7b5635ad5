#include "services/synchronizer/laser_stop.h"

#include <gtest/gtest.h>

#include "tests/services/synchronizer/laser_bench.h"

namespace intaglio::synchronizer {
namespace {

using namespace std::chrono_literals;

class LaserStopTest : public testing::Test {
 protected:
  void StepFor(std::chrono::milliseconds time) {
    for (const auto end = bench_.now + time; bench_.now < end;) {
      bench_.Step();
      stop_.Turn(pressed_, rests_, bench_.now);
    }
  }
  void Press() {
    pressed_ = true;
    StepFor(100ms);
    ASSERT_TRUE(bench_.controller.is_latched());
  }
  std::size_t ResetCount() const {
    return bench_.ReceivedCount(link::LaserFrame::kLaserReset);
  }

  LaserBench bench_;
  LaserStop stop_{bench_.controller};
  bool pressed_ = false, rests_ = true;
};

TEST_F(LaserStopTest, APressLatchesTheControllerAndItsReleaseResetsIt) {
  StepFor(100ms);
  EXPECT_FALSE(bench_.controller.is_latched());
  Press();
  StepFor(2s);
  EXPECT_EQ(ResetCount(), 0u) << "nobody has released it";
  pressed_ = false;
  StepFor(200ms);
  EXPECT_FALSE(bench_.controller.is_latched());
  StepFor(2s);
  EXPECT_EQ(ResetCount(), 1u);
  EXPECT_EQ(bench_.laser.shutters(), 0);
  EXPECT_FALSE(bench_.laser.lamp_on());
}

// A release is no word for a stop that comes behind it.
TEST_F(LaserStopTest, ALaterStopOfTheMachineStaysLatched) {
  Press();
  pressed_ = false;
  StepFor(60ms);
  ASSERT_FALSE(bench_.controller.is_latched());
  bench_.laser.PressStop(true);
  bench_.laser.PressStop(false);
  StepFor(2s);
  EXPECT_TRUE(bench_.controller.is_latched());
  EXPECT_EQ(ResetCount(), 1u);
}

TEST_F(LaserStopTest, AStopThatWasNotHeldHereResetsNothing) {
  bench_.laser.PressStop(true);
  bench_.laser.PressStop(false);
  StepFor(2s);
  EXPECT_TRUE(bench_.controller.is_latched());
  EXPECT_EQ(ResetCount(), 0u);
}

TEST_F(LaserStopTest, AReleaseIsUsedUpWhileTheButtonIsPressed) {
  Press();
  bench_.laser.PressStop(true);
  pressed_ = false;
  StepFor(LaserStop::kResetTime + 100ms);
  const std::size_t tried = ResetCount();
  EXPECT_GT(tried, 1u);
  bench_.laser.PressStop(false);
  StepFor(2s);
  EXPECT_TRUE(bench_.controller.is_latched()) << "released too late for this word";
  EXPECT_EQ(ResetCount(), tried);
}

TEST_F(LaserStopTest, NothingIsResetUnderARunOrAnOpenShutter) {
  Press();
  rests_ = pressed_ = false;
  StepFor(LaserStop::kResetTime + 100ms);
  EXPECT_EQ(ResetCount(), 0u);
  rests_ = true;
  Press();
  bench_.laser.stuck_open = 1;
  StepFor(100ms);
  pressed_ = false;
  StepFor(LaserStop::kResetTime + 100ms);
  EXPECT_EQ(ResetCount(), 0u);
}

TEST_F(LaserStopTest, ANewSessionIsStoppedToo) {
  Press();
  bench_.PowerCycle();
  EXPECT_FALSE(bench_.controller.is_latched());
  StepFor(100ms);
  EXPECT_TRUE(bench_.controller.is_latched());
}

}  // namespace
}  // namespace intaglio::synchronizer
