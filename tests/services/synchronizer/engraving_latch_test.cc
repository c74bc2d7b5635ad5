// What was let go of once stays off until a person arms anew, and nothing older counts.

#include <gmock/gmock.h>

#include <string>

#include "tests/services/synchronizer/fake_cell.h"

namespace intaglio::synchronizer {
namespace {

using testing::IsEmpty;
using namespace std::chrono_literals;
using Phase = Engraving::Phase;

struct Interlock {
  const char* name;
  void (*let_go)(FakeCell&);
  void (*hold)(FakeCell&);
};

const Interlock kInterlocks[] = {
    {"BusStop", [](FakeCell& c) { c.stop_pressed = true; },
     [](FakeCell& c) { c.stop_pressed = false; }},
    {"Key", [](FakeCell& c) { c.laser.key_on = false; },
     [](FakeCell& c) { c.laser.key_on = true; }},
    {"Door", [](FakeCell& c) { c.laser.door_closed = false; },
     [](FakeCell& c) { c.laser.door_closed = true; }},
    {"StopButton", [](FakeCell& c) { c.laser.PressStop(true); },
     [](FakeCell& c) { c.laser.PressStop(false); }},
};

class Latch : public testing::TestWithParam<Interlock> {
 protected:
  bool FiresWithin(std::chrono::milliseconds time) {
    const std::size_t before = cell_.laser.cracks().size();
    cell_.StepFor(time);
    return cell_.laser.cracks().size() != before;
  }
  bool EndsWell() {
    return cell_.StepUntilDone() && cell_.made() == 40 && cell_.Disagreements().empty();
  }
  FakeCell cell_;
};

INSTANTIATE_TEST_SUITE_P(Engraving, Latch, testing::ValuesIn(kInterlocks),
                         [](const auto& i) { return std::string(i.param.name); });

// Who puts a block in with the door open has armed nothing yet: closing it is no start.
TEST_P(Latch, AnArmBeforeTheFirstRunIsSpentByWhatIsOpen) {
  GetParam().let_go(cell_);
  cell_.StepFor(1000ms);
  EXPECT_FALSE(cell_.engraving->faulted()) << "nobody has armed it yet";
  cell_.Grant();
  cell_.StepFor(1000ms);
  EXPECT_TRUE(cell_.engraving->faulted());
  EXPECT_TRUE(cell_.engraving->waits());
  EXPECT_FALSE(cell_.engraving->lost_a_line());
  GetParam().hold(cell_);
  EXPECT_FALSE(FiresWithin(3000ms));
  cell_.GrantAnew();
  EXPECT_TRUE(EndsWell());
}

// A grant that comes after the interlock is held again is the first one that counts: the
// machine's latched stop is reset by it.
TEST_P(Latch, WhatWasOpenBeforeAnyArmCostsNoArm) {
  GetParam().let_go(cell_);
  cell_.StepFor(1000ms);
  GetParam().hold(cell_);
  cell_.StepFor(1000ms);
  cell_.Grant();
  EXPECT_TRUE(EndsWell());
}

TEST_P(Latch, NeitherARepeatedNorARenewedGrantEndsIt) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(10));
  GetParam().let_go(cell_);
  cell_.StepFor(1000ms);
  GetParam().hold(cell_);
  EXPECT_FALSE(FiresWithin(1000ms));
  cell_.Withdraw();
  cell_.StepFor(500ms);
  cell_.RepeatGrant();
  EXPECT_FALSE(FiresWithin(1000ms));
  cell_.RenewGrant();
  EXPECT_FALSE(FiresWithin(1000ms));
  cell_.Grant();  // no withdrawal was ever seen before it
  EXPECT_TRUE(EndsWell());
}

TEST_P(Latch, AnArmWhileItIsOpenIsSpent) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(10));
  GetParam().let_go(cell_);
  cell_.StepFor(1000ms);
  cell_.Grant();
  cell_.StepFor(1000ms);
  GetParam().hold(cell_);
  EXPECT_FALSE(FiresWithin(3000ms));
  cell_.Grant();
  EXPECT_TRUE(EndsWell());
}

// The line was lost first, and the door opened while all waited for it.
TEST_P(Latch, ALostLineIsNoWayRoundIt) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(10));
  cell_.CutLine(true);
  cell_.StepFor(600ms);
  cell_.CutLine(false);
  ASSERT_TRUE(cell_.StepUntil([&] { return cell_.phase() == Phase::kWaiting; }));
  EXPECT_TRUE(cell_.engraving->lost_a_line());
  GetParam().let_go(cell_);
  cell_.StepFor(500ms);
  GetParam().hold(cell_);
  cell_.StepFor(500ms);
  cell_.RenewGrant();
  EXPECT_FALSE(FiresWithin(2000ms));
  cell_.Grant();
  EXPECT_TRUE(EndsWell());
}

TEST_P(Latch, OpenedWhileTheLineWasDownItStaysOpen) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(10));
  cell_.CutLine(true);
  cell_.StepFor(300ms);
  GetParam().let_go(cell_);
  cell_.StepFor(300ms);
  GetParam().hold(cell_);
  cell_.StepFor(300ms);
  cell_.CutLine(false);
  cell_.StepFor(500ms);
  cell_.RenewGrant();
  EXPECT_FALSE(FiresWithin(2000ms));
  cell_.Grant();
  EXPECT_TRUE(EndsWell());
}

// The safe state lets no tick be decided, so the stage does not brake before the Reset.
TEST(EngravingLatch, AStopAtAnyInstantInLockstepIsGotOverByANewArm) {
  for (int instant_ms = 0; instant_ms < 40; ++instant_ms) {
    for (const auto& interlock : kInterlocks) {
      FakeCell cell({.points = 40, .lockstep = true});
      cell.lockstep_ticks_a_step = 1;
      cell.Grant();
      ASSERT_TRUE(cell.StepUntilMade(1));
      cell.StepFor(std::chrono::milliseconds(instant_ms));
      interlock.let_go(cell);
      cell.StepFor(3000ms);
      interlock.hold(cell);
      cell.StepFor(200ms);
      const std::size_t made = cell.laser.cracks().size();
      cell.StepFor(500ms);
      EXPECT_EQ(cell.laser.cracks().size(), made);
      cell.GrantAnew();
      ASSERT_TRUE(cell.StepUntilDone())
          << interlock.name << " at " << instant_ms << ": " << cell.Description();
      EXPECT_EQ(cell.made(), 40U);
      EXPECT_THAT(cell.Disagreements(), IsEmpty());
    }
  }
}

TEST(EngravingLatch, ALostLineIsGotOverByARenewal) {
  FakeCell cell;
  cell.acts_as_job_service = false;
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(10));
  cell.CutLine(true);
  cell.StepFor(600ms);
  cell.CutLine(false);
  cell.StepFor(1000ms);
  const std::size_t made = cell.laser.cracks().size();
  cell.RepeatGrant();
  cell.StepFor(2000ms);
  EXPECT_EQ(cell.laser.cracks().size(), made) << "the same one is spent";
  cell.RenewGrant();
  EXPECT_TRUE(cell.StepUntilDone());
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
}

// An interlock that was open for less than a status, and was seen by the controller
// alone.
TEST(EngravingLatch, APulseThatTheMachineHeldBackWantsAPerson) {
  FakeCell cell;
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(10));
  cell.laser.mute = true;  // no status shows it
  cell.laser.door_closed = false;
  cell.StepFor(30ms);
  cell.laser.door_closed = true;
  cell.laser.mute = false;
  cell.StepFor(2000ms);
  const std::size_t made = cell.laser.cracks().size();
  EXPECT_TRUE(cell.engraving->faulted());
  EXPECT_FALSE(cell.engraving->lost_a_line());
  cell.RenewGrant();
  cell.StepFor(2000ms);
  EXPECT_EQ(cell.laser.cracks().size(), made);
  cell.Grant();
  EXPECT_TRUE(cell.StepUntilDone());
}

// A beam that makes no cracks any more, or a sensor that sees none.
TEST(EngravingLatch, FivePulsesInARowOfWhichNoCrackWasSeenPauseIt) {
  FakeCell cell;
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(10));
  cell.laser.blind = true;
  ASSERT_TRUE(cell.StepUntil([&] { return cell.engraving->faulted(); }));
  cell.StepFor(500ms);
  EXPECT_TRUE(cell.engraving->waits());
  EXPECT_FALSE(cell.engraving->lost_a_line());
  EXPECT_THAT(cell.engraving->message(), testing::HasSubstr("5 pulses in a row"));
  EXPECT_EQ(cell.laser.shutters(), 0);
  EXPECT_FALSE(cell.stage.running());
  // What was on its way when the fifth was reported.
  EXPECT_LE(cell.Count(PointState::kMissed), 7);
  cell.laser.blind = false;
  cell.RepeatGrant();
  const auto missed = cell.Count(PointState::kMissed);
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilDone());
  EXPECT_EQ(cell.Count(PointState::kMissed), missed);
  EXPECT_EQ(cell.made(), 40 - missed);
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
}

// As the machine's profile has it.
TEST(EngravingLatch, HowManyItWaitsForIsTheMachinesChoice) {
  FakeCell cell({.max_missed_in_a_row = 12});
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(10));
  cell.laser.blind = true;
  ASSERT_TRUE(cell.StepUntil([&] { return cell.engraving->faulted(); }));
  EXPECT_THAT(cell.engraving->message(), testing::HasSubstr("12 pulses in a row"));
  EXPECT_GE(cell.Count(PointState::kMissed), 12u);
}

TEST(EngravingLatch, WithoutPhotosensorsWhatWasFiredIsMade) {
  FakeCell cell({.photosensor_feedback = false});
  cell.laser.blind = true;
  cell.Grant();
  ASSERT_TRUE(cell.StepUntilMade(20));
  cell.DieAndTakeUp();
  cell.GrantAnew();
  ASSERT_TRUE(cell.StepUntilDone());
  EXPECT_EQ(cell.made(), 40u);
  EXPECT_THAT(cell.Disagreements(), IsEmpty());
}

// Whatever is prepared: without a grant the machine is as it was.
TEST(EngravingBeforeItsGrant, NeitherLightsNorMovesAnything) {
  for (const bool lockstep : {false, true}) {
    FakeCell cell({.points = 20, .lockstep = lockstep});
    const Vec3 place_mm = cell.stage.at_mm();
    cell.StepFor(10s);
    EXPECT_FALSE(cell.laser.lamp_on());
    EXPECT_EQ(cell.laser.shutters(), 0);
    EXPECT_EQ(cell.stage.at_mm(), place_mm);
    EXPECT_EQ(cell.engraving->message(), TextOf(Missing::kPermission));
    cell.Grant();
    EXPECT_TRUE(cell.StepUntil([&] { return cell.laser.lamp_on(); }));
    EXPECT_TRUE(cell.StepUntilDone()) << cell.Description();
  }
}

}  // namespace
}  // namespace intaglio::synchronizer
