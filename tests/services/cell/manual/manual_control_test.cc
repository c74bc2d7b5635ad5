#include "services/platform/bus/manual_orders.h"
#include "tests/services/cell/manual/manual_bench.h"

namespace intaglio::cell {
namespace {

using ::testing::HasSubstr;

TEST_F(ManualControlTest, AJogGoesToTheLimitAtItsSpeedAndNoFaster) {
  BeginJog();
  EXPECT_EQ(driver_.target, Vec3(100, 10, 10));
  EXPECT_EQ(driver_.speed, 20);
  ComeToRest();
  ManualOrder fast = Jog(2);
  fast.speed_mm_s = 1e9;
  Give(fast);
  EXPECT_EQ(driver_.speed, ManualControl::kMaxSpeedMmS);
}

TEST_F(ManualControlTest, WithoutCompressedAirNothingMoves) {
  driver_.now.fault = intaglio_MOTION_NO_AIR;
  driver_.now.message = "no compressed air";
  Give(Jog(1));
  EXPECT_EQ(driver_.jogs, 0);
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_REFUSED);
  EXPECT_EQ(control_.answer().message, "no compressed air");
}

// Under the same conditions as motion, and done when the controller has it.
TEST_F(ManualControlTest, AZeroOfTheControllerIsSetAtRest) {
  ManualOrder zero = Jog(1);
  zero.kind = intaglio_TEACH_ZERO;
  zero.place = Vec3(0, 0, 0.1);
  zero.sets = 5;
  conditions_.door_closed = false;
  Give(zero);
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_REFUSED);
  EXPECT_EQ(driver_.zeros, 0);
  conditions_.door_closed = true;
  zero.number = kBefore + 2;
  Give(zero);
  ASSERT_EQ(driver_.zeros, 1);
  EXPECT_EQ(driver_.target, Vec3(0, 0, 0.1));
  EXPECT_EQ(driver_.set_axes, (std::array{true, false, true}));
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_ACCEPTED);
  ComeToRest();
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_DONE);
  EXPECT_THAT(control_.answer().message, HasSubstr("the work zero is set"));
}

// The limits of the axes are not its own, and the door holds for it as for them.
TEST_F(ManualControlTest, TheStageThatCarriesTheBlockMovesForTheCellAlone) {
  ManualOrder move = Jog(1);
  move.kind = intaglio_MANUAL_BLOCK;
  move.place = Vec3(-500, 3, 0);
  move.speed_mm_s = 90;
  Give(move);
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_REFUSED);
  EXPECT_THAT(control_.answer().message, HasSubstr("moves for a job alone"));
  EXPECT_EQ(driver_.block_moves, 0);
  ManualOrder drive = move;
  drive.sender = "synchronizer";
  drive.number = kBefore + 2;
  drive.by_cell = true;
  Give(drive);
  ASSERT_EQ(driver_.block_moves, 1) << control_.answer().message;
  EXPECT_EQ(driver_.target, Vec3(-500, 3, 0));
  EXPECT_EQ(driver_.speed, ManualControl::kMaxSpeedMmS);
  conditions_.door_closed = false;
  control_.Turn(conditions_, now_);
  EXPECT_EQ(driver_.holds, 1);
  EXPECT_TRUE(control_.moves()) << "it brakes";
}

TEST_F(ManualControlTest, TheAnswerNamesTheWayThatItGoesOnWithoutAReport) {
  ManualOrder jog = Jog(1);
  jog.speed_mm_s = 50;
  Give(jog);
  ASSERT_EQ(control_.answer().code, intaglio_MANUAL_ACCEPTED);
  EXPECT_THAT(control_.answer().message, HasSubstr("150 ms: at 50 mm/s at most 7.5 mm"));
}

// Coordinates and limits mean little then: a person sees how far it goes, a job does not.
TEST_F(ManualControlTest, AxesWhosePlaceIsLostGoTheirWholeLengthForAPersonAlone) {
  ManualOrder back = Jog(1);
  back.kind = intaglio_MANUAL_MOVE;
  back.place = Vec3(-90, 10, 10);
  Give(back);
  EXPECT_EQ(driver_.jogs, 0);
  EXPECT_THAT(control_.answer().message, HasSubstr("outside the limits"));
  driver_.now.place_lost = "nobody knows where the axes are";
  back.number = kBefore + 2;
  Give(back);
  ASSERT_EQ(driver_.jogs, 1);
  EXPECT_EQ(driver_.target, Vec3(-90, 10, 10));
  ComeToRest();
  ManualOrder drive = Jog(3, "synchronizer");
  drive.by_cell = true;
  Give(drive);
  EXPECT_EQ(driver_.jogs, 1);
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_REFUSED);
  EXPECT_EQ(control_.answer().message, driver_.now.place_lost);
}

TEST_F(ManualControlTest, WithoutChannelsThereIsNoLampAndNoShutter) {
  control_.SetChannels(0);
  ManualOrder lamp = Jog(1);
  lamp.kind = intaglio_MANUAL_LAMP;
  Give(lamp);
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_REFUSED);
  EXPECT_THAT(control_.answer().message, HasSubstr("neither lamp nor shutter"));
}

// The dead-man: 200 ms after the newest command was made, whenever it came.
TEST_F(ManualControlTest, ASilentClientIsHeldAfter200ms) {
  BeginJog();
  now_ += 200ms;
  Turn();
  EXPECT_EQ(driver_.holds, 0);
  now_ += 1ms;
  Turn();
  EXPECT_EQ(driver_.holds, 1);
  ComeToRest();
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_STOPPED);
  EXPECT_FALSE(control_.moves());
}

TEST_F(ManualControlTest, ARepeatedCommandKeepsItMoving) {
  BeginJog();
  for (int i = 0; i < 100; ++i) {
    now_ += 50ms;
    Publish();
    Give(Jog(1));
  }
  EXPECT_EQ(driver_.holds, 0);
  EXPECT_EQ(driver_.jogs, 1);
}

// A network that holds samples back delivers them all at once: they are as old as the
// state that they were made on.
TEST_F(ManualControlTest, ACommandThatWasHeldBackKeepsNothingMoving) {
  BeginJog();
  const ManualOrder late = Jog(1);
  for (int i = 0; i < 30; ++i) {
    now_ += 10ms;
    Publish();
    Give(late);
  }
  EXPECT_EQ(driver_.holds, 1);
  ComeToRest();
  Give(late);
  EXPECT_EQ(driver_.jogs, 1);
  ManualOrder stored = Jog(7);
  stored.seen = 3;  // of another life of the bridge
  Give(stored);
  EXPECT_EQ(driver_.jogs, 1);
}

// A finger that is held while the service is started again echoes the new states.
TEST_F(ManualControlTest, AnOrderThatBeganBeforeThisProcessMovesNothing) {
  for (const std::uint64_t number : {kBefore, std::uint64_t{3}, kBefore + 100000}) {
    ManualOrder held = Jog(1);
    held.number = number;
    for (int i = 0; i < 50; ++i) {
      now_ += 20ms;
      Publish();
      held.seen = number_;
      Give(held);
    }
    EXPECT_EQ(driver_.jogs, 0) << number;
    EXPECT_EQ(control_.answer().number, number);
    EXPECT_EQ(control_.answer().code, intaglio_MANUAL_REFUSED);
    EXPECT_THAT(control_.answer().message, HasSubstr("started again"));
  }
  ManualOrder pressed = Jog(1);
  pressed.number = bus::NumberOfOrder(kBefore + 100000, number_);
  Give(pressed);
  EXPECT_EQ(driver_.jogs, 1);
}

TEST(NumberOfOrder, IsThatOfTheStateOrTheNextOne) {
  EXPECT_EQ(bus::NumberOfOrder(0, 5000), 5000u);
  EXPECT_EQ(bus::NumberOfOrder(5000, 5000), 5001u);
  EXPECT_EQ(bus::NumberOfOrder(5001, 5000), 5002u);
  EXPECT_EQ(bus::NumberOfOrder(5001, 5010), 5010u);
  EXPECT_EQ(bus::NumberOfOrder(std::uint64_t{9} << 40, 5000), 5000u);
  std::uint64_t last = 0;
  for (std::uint64_t i = 0; i < 60; ++i) {
    const std::uint64_t next = bus::NumberOfOrder(last, 5000 + i / 20);
    ASSERT_GT(next, last);
    ASSERT_TRUE(bus::BeganAmong(next, 5000, 5000 + i / 20)) << i;
    last = next;
  }
  EXPECT_FALSE(bus::BeganAmong(4999, 5000, 5100));
  EXPECT_FALSE(bus::BeganAmong(5000 + 165, 5000, 5100));
}

TEST_F(ManualControlTest, LettingGoOrTheEndOfItsProcessEndsTheJog) {
  BeginJog();
  ManualOrder none = Jog(1);
  none.kind = intaglio_MANUAL_NONE;
  Give(none);
  EXPECT_EQ(driver_.holds, 1);
  ComeToRest();
  Publish();
  Give(Jog(2));
  EXPECT_EQ(driver_.jogs, 2);
  control_.LoseSender("bob");
  Turn();
  EXPECT_EQ(driver_.holds, 1);
  control_.LoseSender("ann");
  Turn();
  EXPECT_EQ(driver_.holds, 2);
}

struct Opened {
  const char* name;
  bool ManualConditions::*condition;
  bool value;
  const char* text;
  bool is_report = false;  ///< what is missing is a report, not a state
};

class EachInterlock : public ManualControlTest,
                      public ::testing::WithParamInterface<Opened> {};

// Not only is a jog refused; one that moves ends, and does not go on by itself.
TEST_P(EachInterlock, RefusesAndEndsAJogForGood) {
  const bool good = conditions_.*GetParam().condition;
  conditions_.*GetParam().condition = GetParam().value;
  Give(Jog(1));
  EXPECT_EQ(driver_.jogs, 0);
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_REFUSED);
  EXPECT_THAT(control_.answer().message, HasSubstr(GetParam().text));
  EXPECT_EQ(control_.answer().reports_missing, GetParam().is_report);
  conditions_.*GetParam().condition = good;
  Give(Jog(1));
  EXPECT_EQ(driver_.jogs, 0) << "a refused number is spent";
  Give(Jog(2));
  ASSERT_EQ(driver_.jogs, 1);
  conditions_.*GetParam().condition = GetParam().value;
  Turn();
  EXPECT_EQ(driver_.holds, 1);
  conditions_.*GetParam().condition = good;
  ComeToRest();
  EXPECT_THAT(control_.answer().message, HasSubstr(GetParam().text));
  EXPECT_FALSE(control_.answer().reports_missing) << "no program gives it again";
  for (int i = 0; i < 5; ++i) {
    Publish();
    Give(Jog(2));
  }
  EXPECT_EQ(driver_.jogs, 1) << "nothing restarts by itself";
}

INSTANTIATE_TEST_SUITE_P(
    Of, EachInterlock,
    ::testing::Values(
        Opened{"ArmedJob", &ManualConditions::job_armed, true, "a job is armed"},
        Opened{"Run", &ManualConditions::run_active, true, "a job moves"},
        Opened{"NoJobService", &ManualConditions::permission_fresh, false, "job service",
               true},
        Opened{"BusStop", &ManualConditions::stop_pressed, true, "emergency stop"},
        Opened{"LaserLine", &ManualConditions::laser_line_up, false, "not known", true},
        Opened{"Key", &ManualConditions::key_on, false, "key"},
        Opened{"Door", &ManualConditions::door_closed, false, "door"},
        Opened{"Stop", &ManualConditions::stop_released, false, "stop button"}),
    [](const auto& opened) { return std::string(opened.param.name); });

// Nothing comes of a process that has died; the order is held all the time.
TEST_F(ManualControlTest, AMotionEndsWhenKeyDoorAndStopAreOlderThan150ms) {
  BeginJog();
  are_reported_ = false;
  for (int ms = 0; ms < 150; ms += 50) {
    now_ += 50ms;
    Publish();
    Give(Jog(1));
  }
  EXPECT_EQ(driver_.holds, 0);
  now_ += 1ms;
  Give(Jog(1));
  EXPECT_EQ(driver_.holds, 1);
  ComeToRest();
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_STOPPED);
  // 20 mm/s for 150 ms.
  EXPECT_THAT(control_.answer().message, HasSubstr("150 ms after the last report"));
  EXPECT_THAT(control_.answer().message, HasSubstr("at 20 mm/s at most 3.0 mm"));
  Publish();
  Give(Jog(2));
  EXPECT_EQ(driver_.jogs, 1) << "and none begins";
}

// A report that comes says how old its content is: a laser that is silent is no news.
TEST_F(ManualControlTest, TheAgeOfAReportCountsFromItsController) {
  conditions_.interlocks_age = 100ms;
  BeginJog();
  are_reported_ = false;
  now_ += 50ms;
  Turn();
  EXPECT_EQ(driver_.holds, 0);
  now_ += 1ms;
  Turn();
  EXPECT_EQ(driver_.holds, 1);
  ComeToRest();
  are_reported_ = true;
  conditions_.interlocks_age = 151ms;
  Publish();
  Give(Jog(2));
  EXPECT_EQ(driver_.jogs, 1);
  EXPECT_THAT(control_.answer().message, HasSubstr("not known"));
}

// grbl and isel answer nothing while they home, and watch their own chain.
TEST_F(ManualControlTest, HomingNeedsTheReportsAndNotThoseOfASilentController) {
  conditions_.interlocks_at = now_;
  conditions_.interlocks_age = 10s;
  ManualOrder home = Jog(1);
  home.kind = intaglio_MANUAL_HOME;
  EXPECT_EQ(WhyNoMotionByHand(conditions_, driver_.now, home, now_ + 150ms), "");
  EXPECT_THAT(WhyNoMotionByHand(conditions_, driver_.now, home, now_ + 151ms),
              HasSubstr("not known"));
  EXPECT_THAT(WhyNoMotionByHand(conditions_, driver_.now, Jog(2), now_),
              HasSubstr("not known"));
}

TEST_F(ManualControlTest, TheSynchronizerDrivesForAnArmedJobAndNotInARun) {
  conditions_.job_armed = true;
  ManualOrder order = Jog(1, "synchronizer");
  order.by_cell = true;
  Give(order);
  EXPECT_EQ(driver_.jogs, 1);
  conditions_.run_active = true;
  Turn();
  EXPECT_EQ(driver_.holds, 1);
}

TEST_F(ManualControlTest, APlaceOutsideTheLimitsIsRefusedWithAxisAndLimits) {
  ManualOrder order = Jog(1);
  order.kind = intaglio_MANUAL_MOVE;
  order.place = Vec3(50, 80.001, 10);
  Give(order);
  EXPECT_EQ(driver_.jogs, 0);
  EXPECT_THAT(control_.answer().message, HasSubstr("y 80.001 is outside the limits, 0"));
  order.number = kBefore + 2;
  order.place = Vec3(50, std::nan(""), 10);
  Give(order);
  EXPECT_EQ(driver_.jogs, 0);
  order.number = kBefore + 3;
  order.place = Vec3(50, 80, 10);
  Give(order);
  EXPECT_EQ(driver_.target, Vec3(50, 80, 10));
  ComeToRest();
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_DONE);
}

TEST_F(ManualControlTest, ASecondPersonWaits) {
  BeginJog();
  Give(Jog(1, "bob"));
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_REFUSED);
  EXPECT_THAT(control_.answer().message, HasSubstr("ann moves the stage"));
  EXPECT_EQ(driver_.holds, 0);
  EXPECT_EQ(control_.held_by(), "ann");
}

TEST_F(ManualControlTest, AFaultOfBeforeIsClearedWhileTheKeyIsHeld) {
  driver_.now.fault = intaglio_MOTION_SAFE_STATE;
  Give(Jog(1));
  EXPECT_EQ(driver_.clears, 1);
  EXPECT_EQ(driver_.jogs, 0);
  driver_.now.fault = intaglio_MOTION_OK;
  Turn();
  EXPECT_EQ(driver_.jogs, 1);
}

TEST_F(ManualControlTest, AFamilyThatCannotIsReported) {
  ManualOrder home = Jog(1);
  home.kind = intaglio_MANUAL_HOME;  // the fake has none
  Give(home);
  EXPECT_EQ(control_.answer().code, intaglio_MANUAL_REFUSED);
  EXPECT_THAT(control_.answer().message, HasSubstr("own panel"));
}

}  // namespace
}  // namespace intaglio::cell
