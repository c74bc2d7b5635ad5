// The lock of the door and the compressed air of a stage: without them nothing is fired,
// and what let go in a run costs the arm.

#include <gmock/gmock.h>

#include "tests/services/synchronizer/fake_cell.h"

namespace intaglio::synchronizer {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using namespace std::chrono_literals;

class DoorLock : public testing::Test {
 protected:
  void ExpectNoMoreCracks(std::size_t cracks) {
    cell_.RenewGrant();
    cell_.StepFor(3s);
    EXPECT_EQ(cell_.laser.cracks().size(), cracks);
    EXPECT_EQ(cell_.laser.shutters(), 0);
  }
  void GoOnToTheEnd() {
    cell_.GrantAnew();
    ASSERT_TRUE(cell_.StepUntilDone()) << cell_.Description();
    EXPECT_THAT(cell_.Disagreements(), IsEmpty());
    EXPECT_EQ(cell_.made(), cell_.points_mm.size());
  }

  FakeCell cell_{{.points = 160, .needs_door_lock = true}};
};

TEST_F(DoorLock, HoldsInTheWholeJob) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilDone()) << cell_.Description();
  EXPECT_EQ(cell_.made(), cell_.points_mm.size());
}

TEST_F(DoorLock, ThatDoesNotHoldLetsNothingBeArmed) {
  cell_.laser.lock_broken = true;
  cell_.Grant();
  cell_.StepFor(5s);
  EXPECT_EQ(cell_.laser.newest_arm_at(), 0ns);
  EXPECT_THAT(cell_.engraving->message(),
              HasSubstr("the lock of the door does not hold"));
  EXPECT_TRUE(cell_.engraving->faulted());
  ExpectNoMoreCracks(0);
  cell_.laser.lock_broken = false;
  GoOnToTheEnd();
}

TEST_F(DoorLock, ThatLetsGoInARunCostsTheArm) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(20));
  cell_.laser.lock_broken = true;
  cell_.StepFor(1s);
  const std::size_t cracks = cell_.laser.cracks().size();
  ASSERT_LT(cracks, cell_.points_mm.size());
  EXPECT_THAT(cell_.engraving->message(),
              HasSubstr("the lock of the door does not hold"));
  EXPECT_FALSE(cell_.engraving->lost_a_line()) << "it would go on by itself";
  cell_.laser.lock_broken = false;
  ExpectNoMoreCracks(cracks);
  GoOnToTheEnd();
}

// Whatever the lock says, an open door is an open door.
TEST_F(DoorLock, DoesNotHideADoorThatIsForced) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(20));
  cell_.laser.door_closed = false;
  ++cell_.laser.openings;
  cell_.StepFor(1s);
  const std::size_t cracks = cell_.laser.cracks().size();
  EXPECT_THAT(cell_.engraving->message(), HasSubstr("the door is open"));
  cell_.laser.door_closed = true;
  ExpectNoMoreCracks(cracks);
  GoOnToTheEnd();
}

TEST_F(DoorLock, IsRefusedWhenTheControllerHasNone) {
  FakeCell cell({.points = 40, .needs_door_lock = true});
  cell.laser.locks_door = false;
  cell.CutLine(true);
  cell.StepFor(600ms);
  cell.CutLine(false);
  cell.Grant();
  cell.StepFor(3s);
  EXPECT_THAT(cell.engraving->message(), HasSubstr("reports no lock of the door"));
  EXPECT_EQ(cell.laser.lamp_switched_on_count(), 0);
  EXPECT_EQ(cell.laser.cracks().size(), 0u);
}

class CompressedAir : public DoorLock {
 protected:
  void TurnOff() { cell_.stage.Fail(intaglio_MOTION_NO_AIR, "no compressed air"); }
  void TurnOn() { cell_.stage.Fail(intaglio_MOTION_OK, ""); }
};

TEST_F(CompressedAir, IsWaitedForBeforeTheFirstRun) {
  TurnOff();
  cell_.Grant();
  cell_.StepFor(3s);
  EXPECT_EQ(cell_.engraving->message(), "no compressed air");
  EXPECT_EQ(cell_.laser.newest_arm_at(), 0ns);
  EXPECT_EQ(cell_.laser.shutters(), 0);
  TurnOn();
  ASSERT_TRUE(cell_.StepUntilDone()) << cell_.Description();
  EXPECT_EQ(cell_.made(), cell_.points_mm.size());
}

TEST_F(CompressedAir, ThatFailsInARunCostsTheArm) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(20));
  TurnOff();
  cell_.StepFor(2s);
  const std::size_t cracks = cell_.laser.cracks().size();
  ASSERT_LT(cracks, cell_.points_mm.size());
  EXPECT_THAT(cell_.engraving->message(), HasSubstr("no compressed air"));
  EXPECT_FALSE(cell_.engraving->lost_a_line()) << "it would go on by itself";
  TurnOn();
  ExpectNoMoreCracks(cracks);
  GoOnToTheEnd();
}

}  // namespace
}  // namespace intaglio::synchronizer
