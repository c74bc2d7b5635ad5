#include "services/synchronizer/light_by_hand.h"

#include <gtest/gtest.h>

#include "tests/services/synchronizer/laser_bench.h"

namespace intaglio::synchronizer {
namespace {

using namespace std::chrono_literals;

class LightByHandTest : public testing::Test {
 protected:
  /// A bridge that publishes every 20 ms what is held, unless it is silent.
  void StepFor(std::chrono::milliseconds time) {
    for (const auto end = bench_.now + time; bench_.now < end;) {
      bench_.Step();
      if (publishes_ && bench_.now >= next_) Publish();
      light_.Turn(free_, bench_.now);
    }
  }
  void Publish() {
    next_ = bench_.now + 20ms;
    intaglio_ManualState state{};
    state.number = ++number_;
    state.lamp_by_hand = lamp_;
    state.shutters_by_hand = shutters_;
    light_.Receive(state, true, bench_.now);
  }
  void ExpectDark(const char* why) {
    EXPECT_FALSE(bench_.laser.lamp_on()) << why;
    EXPECT_EQ(bench_.laser.shutters(), 0) << why;
  }
  /// Lit from dark.
  void Light() {
    StepFor(100ms);
    lamp_ = true;
    StepFor(200ms);
    ASSERT_TRUE(bench_.laser.lamp_on());
  }

  LaserBench bench_;
  LightByHand light_{bench_.controller, FakeLaser::kRateHz};
  bool publishes_ = true, free_ = true, lamp_ = false;
  std::uint8_t shutters_ = 0;
  std::uint64_t number_ = 7ull << 32;
  std::chrono::nanoseconds next_{0};
};

TEST_F(LightByHandTest, SwitchesWhatIsHeldAndTakesItBack) {
  Light();
  EXPECT_EQ(bench_.laser.shutters(), 0);
  lamp_ = false;
  StepFor(100ms);
  ExpectDark("let go");
  shutters_ = 2;
  StepFor(200ms);
  EXPECT_EQ(bench_.laser.shutters(), 2);
  EXPECT_FALSE(bench_.laser.lamp_on());
  shutters_ = 0;
  StepFor(100ms);
  ExpectDark("let go");
}

TEST_F(LightByHandTest, GoesOffWithASilentBridge) {
  Light();
  publishes_ = false;
  StepFor(LightByHand::kLease + 50ms);
  ExpectDark("silent");
}

TEST_F(LightByHandTest, GoesOffWithAJobAndWithAStop) {
  Light();
  free_ = false;
  StepFor(100ms);
  ExpectDark("not free");
  free_ = true;
  StepFor(200ms);
  EXPECT_TRUE(bench_.laser.lamp_on()) << "it is still held";
}

// Nothing is left of what ended: a stored state, or the first of a bridge.
TEST_F(LightByHandTest, AStateAloneSwitchesNothingOn) {
  lamp_ = true;
  shutters_ = 1;
  Publish();
  publishes_ = false;
  StepFor(90ms);
  ExpectDark("the first state");
  number_ = 9ull << 32;  // another bridge
  Publish();
  StepFor(90ms);
  ExpectDark("the first state of another bridge");
}

// What a synchronizer of before has armed does not fire into the open shutter.
TEST_F(LightByHandTest, DisarmsBeforeItOpensAShutter) {
  bench_.WarmUp();
  link::ArmWindow window{bench_.laser.tick() + 50, false, std::vector<bool>(20, true)};
  ASSERT_TRUE(bench_.controller.Arm(window));
  bench_.StepFor(20ms);
  StepFor(100ms);
  shutters_ = 1;
  StepFor(200ms);
  ASSERT_EQ(bench_.laser.shutters(), 1);
  bench_.PassTicks(200);
  StepFor(50ms);
  EXPECT_TRUE(bench_.laser.cracks().empty());
}

TEST_F(LightByHandTest, ALampThatWasOnStaysOnWhenItIsLetGo) {
  bench_.WarmUp();
  Light();
  lamp_ = false;
  StepFor(200ms);
  EXPECT_TRUE(bench_.laser.lamp_on());
}

}  // namespace
}  // namespace intaglio::synchronizer
