#include "services/synchronizer/lamp_hold.h"

#include <gtest/gtest.h>

#include "tests/services/synchronizer/laser_bench.h"

namespace intaglio::synchronizer {
namespace {

using namespace std::chrono_literals;

class LampHoldTest : public testing::Test {
 protected:
  void StepFor(std::chrono::milliseconds time, bool stopped = false) {
    for (const auto end = bench_.now + time; bench_.now < end;) {
      bench_.Step();
      hold_.Turn(stopped, bench_.now);
    }
  }
  /// As a job leaves it.
  void EndJob() {
    bench_.WarmUp();
    ASSERT_TRUE(bench_.laser.lamp_on());
    hold_.Begin(bench_.now);
  }

  LaserBench bench_;
  LampHold hold_{bench_.controller, 2.5, FakeLaser::kRateHz};
};

TEST_F(LampHoldTest, KeepsTheLampOnForAsLongAsTheProfileAllows) {
  EndJob();
  StepFor(2400ms);
  EXPECT_TRUE(bench_.laser.lamp_on());
  EXPECT_TRUE(hold_.holds());
  StepFor(300ms);
  EXPECT_FALSE(bench_.laser.lamp_on());
  EXPECT_FALSE(hold_.holds());
}

TEST_F(LampHoldTest, GoesOffAtOnceWithAStop) {
  EndJob();
  StepFor(100ms);
  StepFor(30ms, true);
  EXPECT_FALSE(bench_.laser.lamp_on());
}

TEST_F(LampHoldTest, AnEngravingTakesTheLampOver) {
  EndJob();
  hold_.Yield();
  StepFor(5s);
  EXPECT_TRUE(bench_.laser.lamp_on());
  EXPECT_EQ(bench_.laser.lamp_switched_on_count(), 1);
}

TEST_F(LampHoldTest, GoesOffWhenTheLineIsBack) {
  EndJob();
  bench_.CutLine(true);
  StepFor(4s);
  EXPECT_TRUE(bench_.laser.lamp_on());
  bench_.CutLine(false);
  StepFor(1s);
  EXPECT_FALSE(bench_.laser.lamp_on());
}

TEST(LampHold, WithoutALimitNothingIsHeld) {
  LaserBench bench;
  LampHold hold(bench.controller, 0, FakeLaser::kRateHz);
  EXPECT_FALSE(hold.holds_lamps());
  hold.Begin(bench.now);
  EXPECT_FALSE(hold.holds());
}

}  // namespace
}  // namespace intaglio::synchronizer
