// Lamp and shutters by hand: the same dead-man and the same conditions as motion.

#include "tests/services/cell/manual/manual_bench.h"

namespace intaglio::cell {
namespace {

using ::testing::HasSubstr;

class ManualLight : public ManualControlTest {
 protected:
  ManualLight() { control_.SetChannels(2); }
  std::uint64_t order_ = 10;
  ManualOrder Light(std::uint64_t number, intaglio_ManualCommandKind kind,
                    std::uint32_t channel = 1) const {
    ManualOrder order = Jog(number);
    order.kind = kind;
    order.channel = channel;
    return order;
  }
  ManualOrder Lamp(std::uint64_t number) const {
    return Light(number, intaglio_MANUAL_LAMP);
  }
  void ExpectDark() {
    EXPECT_FALSE(control_.lamp_by_hand());
    EXPECT_EQ(control_.shutters_by_hand(), 0);
    EXPECT_FALSE(control_.moves());
  }
};

TEST_F(ManualLight, IsHeldUntilItsClientIsSilentFor200ms) {
  Give(Lamp(1));
  EXPECT_TRUE(control_.lamp_by_hand());
  EXPECT_EQ(control_.shutters_by_hand(), 0);
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_ACCEPTED);
  conditions_.lamp_on = true;
  for (int i = 0; i < 100; ++i) {
    now_ += 50ms;
    Publish();
    Give(Lamp(1));
  }
  EXPECT_TRUE(control_.lamp_by_hand());
  now_ += 200ms;
  Turn();
  EXPECT_TRUE(control_.lamp_by_hand());
  now_ += 1ms;
  Turn();
  ExpectDark();
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_STOPPED);
  EXPECT_EQ(driver_.jogs + driver_.holds + driver_.clears, 0) << "the stage rests";
  Publish();
  Give(Lamp(1));
  ExpectDark();
}

TEST_F(ManualLight, OpensTheShutterOfItsChannelAlone) {
  Give(Light(1, intaglio_MANUAL_SHUTTER, 2));
  EXPECT_EQ(control_.shutters_by_hand(), 2);
  EXPECT_FALSE(control_.lamp_by_hand());
  ManualOrder none = Light(1, intaglio_MANUAL_NONE);
  Give(none);
  ExpectDark();
  for (const std::uint32_t channel : {0u, 3u, 33u}) {
    Publish();
    Give(Light(10 + channel, intaglio_MANUAL_SHUTTER, channel));
    ExpectDark();
    EXPECT_EQ(control_.answer().code, intaglio_MANUAL_REFUSED);
    EXPECT_THAT(control_.answer().message, HasSubstr("1 to 2"));
  }
}

TEST_F(ManualLight, NeedsWhatMotionNeeds) {
  for (bool ManualConditions::*good :
       {&ManualConditions::key_on, &ManualConditions::door_closed,
        &ManualConditions::stop_released, &ManualConditions::permission_fresh,
        &ManualConditions::laser_line_up}) {
    Publish();
    Give(Lamp(++order_));
    ASSERT_TRUE(control_.lamp_by_hand());
    conditions_.*good = false;
    Turn();
    ExpectDark();
    conditions_.*good = true;
    Publish();
    Give(Lamp(order_));
    ExpectDark();
  }
  for (bool ManualConditions::*bad :
       {&ManualConditions::job_armed, &ManualConditions::run_active,
        &ManualConditions::stop_pressed}) {
    conditions_.*bad = true;
    Publish();
    Give(Lamp(++order_));
    ExpectDark();
    EXPECT_EQ(control_.answer().code, intaglio_MANUAL_REFUSED);
    conditions_.*bad = false;
  }
}

TEST_F(ManualLight, GoesOffWithoutReportsOfKeyAndDoor) {
  Give(Lamp(++order_));
  ASSERT_TRUE(control_.lamp_by_hand());
  are_reported_ = false;
  now_ += 151ms;
  Publish();
  Give(Lamp(order_));
  ExpectDark();
}

// A fault of the stage does not matter to the lamp.
TEST_F(ManualLight, ClearsNoFaultOfTheStage) {
  driver_.now.fault = intaglio_MOTION_STARVED;
  Give(Lamp(1));
  EXPECT_TRUE(control_.lamp_by_hand());
  EXPECT_EQ(driver_.clears, 0);
}

TEST_F(ManualLight, EndsWhenTheLaserDoesNotShowIt) {
  const auto hold = [&](std::uint64_t number, Nanoseconds time) {
    for (const auto end = now_ + time; now_ < end; now_ += 50ms) {
      Publish();
      Give(Lamp(number));
    }
  };
  hold(1, 1900ms);
  EXPECT_TRUE(control_.lamp_by_hand());
  hold(1, 300ms);
  ExpectDark();
  EXPECT_THAT(control_.answer().message, HasSubstr("not switched it on"));
  hold(2, 500ms);
  conditions_.lamp_on = true;
  hold(2, 5s);
  EXPECT_TRUE(control_.lamp_by_hand());
  conditions_.lamp_on = false;
  hold(2, 100ms);
  ExpectDark();
  EXPECT_THAT(control_.answer().message, HasSubstr("switched it off"));
}

TEST_F(ManualLight, ExcludesMotionAndIsExcludedByIt) {
  Give(Lamp(1));
  Give(Jog(2, "bob"));
  EXPECT_EQ(driver_.jogs, 0);
  EXPECT_THAT(control_.answer().message, HasSubstr("ann has lamp or shutter by hand"));
  Give(Light(1, intaglio_MANUAL_NONE));
  ExpectDark();
  Publish();
  Give(Jog(3, "bob"));
  EXPECT_EQ(driver_.jogs, 1);
  Give(Lamp(4));
  EXPECT_FALSE(control_.lamp_by_hand());
}

}  // namespace
}  // namespace intaglio::cell
