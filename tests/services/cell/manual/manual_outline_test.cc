// The outline of the guide laser: the same dead-man and the same conditions as motion.

#include <limits>

#include "tests/services/cell/manual/manual_bench.h"

namespace intaglio::cell {
namespace {

using ::testing::HasSubstr;

class ManualOutline : public ManualControlTest {
 protected:
  ManualOrder Outline(std::uint64_t number, const std::string& sender = "ann") const {
    ManualOrder order = Jog(number, sender);
    order.kind = intaglio_MANUAL_OUTLINE;
    order.speed_mm_s = 2000;
    order.corners = {Vec2(10, 20), Vec2(30, 20), Vec2(30, 50)};
    return order;
  }
  void Begin() {
    Publish();
    Give(Outline(++order_));
    ASSERT_EQ(driver_.outlines, ++begun_) << control_.answer().message;
    ASSERT_TRUE(control_.moves());
    ASSERT_EQ(control_.answer().code, intaglio_MANUAL_ACCEPTED);
  }
  /// Braked by one Hold, then at rest, and not begun again by the same order.
  void ExpectEnded(const std::string& reason) {
    EXPECT_EQ(driver_.holds, begun_) << reason;
    ComeToRest();
    EXPECT_FALSE(control_.moves());
    EXPECT_EQ(control_.answer().code, intaglio_MANUAL_STOPPED);
    EXPECT_THAT(control_.answer().message, HasSubstr(reason));
    Publish();
    Give(Outline(order_));
    EXPECT_EQ(driver_.outlines, begun_) << "it begins again by itself";
    EXPECT_FALSE(control_.moves());
  }

  std::uint64_t order_ = 10;
  int begun_ = 0;
};

TEST_F(ManualOutline, IsDrawnAtItsSpeedUntilItIsLetGo) {
  Begin();
  EXPECT_EQ(driver_.corners, Outline(1).corners);
  EXPECT_EQ(driver_.speed, 2000);
  for (int i = 0; i < 100; ++i) {
    now_ += 50ms;
    Publish();
    Give(Outline(order_));
  }
  EXPECT_TRUE(control_.moves());
  EXPECT_EQ(driver_.holds, 0);
  ManualOrder none = Outline(order_);
  none.kind = intaglio_MANUAL_NONE;
  Give(none);
  ExpectEnded("let go");
}

TEST_F(ManualOutline, EndsWhenItsClientIsSilentFor200msOrGone) {
  Begin();
  now_ += 200ms;
  Turn();
  EXPECT_EQ(driver_.holds, 0);
  now_ += 1ms;
  Turn();
  ExpectEnded("let go");
  Begin();
  control_.LoseSender("ann");
  Turn();
  ExpectEnded("let go");
}

TEST_F(ManualOutline, EndsAndIsRefusedWhereMotionIs) {
  for (bool ManualConditions::*good :
       {&ManualConditions::key_on, &ManualConditions::door_closed,
        &ManualConditions::stop_released, &ManualConditions::permission_fresh,
        &ManualConditions::laser_line_up}) {
    Begin();
    conditions_.*good = false;
    Turn();
    conditions_.*good = true;
    ExpectEnded("");
  }
  for (const auto& [bad, reason] :
       {std::pair{&ManualConditions::job_armed, "a job is armed"},
        std::pair{&ManualConditions::run_active, "a job moves the stage"},
        std::pair{&ManualConditions::stop_pressed, "emergency stop"}}) {
    Begin();
    conditions_.*bad = true;
    Turn();
    ExpectEnded(reason);
    Publish();
    Give(Outline(++order_));
    EXPECT_EQ(driver_.outlines, begun_);
    EXPECT_EQ(control_.answer().code, intaglio_MANUAL_REFUSED);
    EXPECT_THAT(control_.answer().message, HasSubstr(reason));
    conditions_.*bad = false;
  }
}

TEST_F(ManualOutline, EndsWithoutReportsOfKeyDoorAndStopAndWithAFault) {
  Begin();
  are_reported_ = false;
  now_ += 151ms;
  Publish();
  Give(Outline(order_));
  are_reported_ = true;
  ExpectEnded("key and door are not known");
  Begin();
  driver_.now.fault = intaglio_MOTION_SAFE_STATE;
  driver_.now.message = "key, door or stop button is open";
  Turn();
  ExpectEnded("key, door or stop button is open");
}

TEST_F(ManualOutline, StaysWithinTheLimits) {
  for (const Vec2& outside : {Vec2(100.001, 10), Vec2(10, 80.001), Vec2(-0.001, 10),
                              Vec2(std::numeric_limits<double>::quiet_NaN(), 10)}) {
    ManualOrder order = Outline(++order_);
    order.corners.push_back(outside);
    Publish();
    Give(order);
    EXPECT_EQ(driver_.outlines, 0);
    EXPECT_EQ(control_.answer().code, intaglio_MANUAL_REFUSED);
    EXPECT_THAT(control_.answer().message, HasSubstr("outside the limits"));
  }
  ManualOrder still = Outline(++order_);
  still.speed_mm_s = 0;
  Publish();
  Give(still);
  EXPECT_EQ(driver_.outlines, 0);
  EXPECT_THAT(control_.answer().message, HasSubstr("give one above 0"));
}

TEST_F(ManualOutline, IsAloneAmongTheOrders) {
  Begin();
  Give(Jog(1, "bob"));
  EXPECT_EQ(driver_.jogs, 0);
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_REFUSED);
  EXPECT_EQ(driver_.holds, 0);
}

// What a machine without a guide laser answers is the answer to the person.
TEST_F(ManualOutline, IsRefusedAsTheDriverRefusesIt) {
  class NoGuide final : public drivers::HandMotion {
   public:
    const drivers::DriverState& state() const override { return now; }
    Status Hold() override { return {}; }
    Status ClearFault() override { return {}; }
    drivers::DriverState now;
  } driver;
  driver.now = driver_.now;
  ManualControl control(driver, {Vec3::Zero(), Vec3(100, 80, 60)}, {"x", "y", "z"});
  control.NotePublished(number_, now_);
  conditions_.interlocks_at = now_;
  control.Receive(Outline(1), now_);
  control.Turn(conditions_, now_);
  EXPECT_FALSE(control.moves());
  EXPECT_EQ(control.answer().code, intaglio_MANUAL_REFUSED);
  EXPECT_THAT(control.answer().message, HasSubstr("has no guide laser"));
}

}  // namespace
}  // namespace intaglio::cell
