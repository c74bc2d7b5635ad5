// A line that leads to another machine: nothing is lit or fired there, and the job goes
// on with the right one only when a person arms it again.

#include <gmock/gmock.h>

#include "tests/services/synchronizer/fake_cell.h"

namespace intaglio::synchronizer {
namespace {

using testing::IsEmpty;
using namespace std::chrono_literals;

constexpr char kLaserRefusal[] =
    "the line at /dev/ttyUSB0 leads to laser 'B-17', the profile of els-03 expects "
    "'A-03': "
    "swap the cables or correct laser_line.serial_number";
constexpr char kStageRefusal[] = "the line at /dev/ttyUSB1 leads to another stage";

class EngravingDevice : public testing::Test {
 protected:
  explicit EngravingDevice(const CellOptions& options = {.points = 160})
      : cell_(options) {}
  /// The cable is pulled out and put in at the laser with this serial number.
  void ReplugTo(const std::string& serial_number) {
    cell_.CutLine(true);
    cell_.StepFor(600ms);
    cell_.laser.serial_number = serial_number;
    cell_.CutLine(false);
    cell_.StepFor(600ms);
  }
  void ExpectHalted(const std::string& message, std::size_t cracks) {
    EXPECT_EQ(cell_.laser.cracks().size(), cracks);
    EXPECT_EQ(cell_.engraving->message(), message + ", then resume");
    EXPECT_TRUE(cell_.engraving->waits());
    EXPECT_TRUE(cell_.engraving->faulted());
    EXPECT_FALSE(cell_.engraving->lost_a_line()) << "it would go on by itself";
  }
  void GoOnToTheEnd() {
    cell_.GrantAnew();
    ASSERT_TRUE(cell_.StepUntilDone()) << cell_.Description();
    EXPECT_THAT(cell_.Disagreements(), IsEmpty());
    EXPECT_EQ(cell_.made(), cell_.points_mm.size());
  }

  FakeCell cell_;
};

class AtAnotherLaser : public EngravingDevice {
 protected:
  AtAnotherLaser() : EngravingDevice({.points = 160, .laser_serial_number = "B-17"}) {}
};

TEST_F(AtAnotherLaser, IsNotLitAndCostsTheArm) {
  cell_.StepFor(1000ms);
  EXPECT_EQ(cell_.engraving->message(), kLaserRefusal);
  cell_.Grant();
  cell_.StepFor(5s);
  ExpectHalted(kLaserRefusal, 0);
  EXPECT_EQ(cell_.laser.lamp_switched_on_count(), 0);
  ReplugTo("A-03");
  cell_.RenewGrant();
  cell_.StepFor(5s);
  EXPECT_EQ(cell_.laser.cracks().size(), 0u) << "armed for another laser";
  GoOnToTheEnd();
}

TEST_F(EngravingDevice, AnotherLaserInMidJobIsNotFiredAndCostsTheArm) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(20));
  ReplugTo("B-17");
  const std::size_t cracks = cell_.laser.cracks().size();
  ASSERT_LT(cracks, cell_.points_mm.size());
  cell_.RenewGrant();
  cell_.StepFor(3s);
  ExpectHalted(kLaserRefusal, cracks);
  EXPECT_EQ(cell_.laser.shutters(), 0);
  EXPECT_FALSE(cell_.laser.lamp_on());
  ReplugTo("A-03");
  cell_.RenewGrant();
  cell_.StepFor(3s);
  EXPECT_EQ(cell_.laser.cracks().size(), cracks) << "nothing goes on by itself";
  GoOnToTheEnd();
}

TEST_F(EngravingDevice, AnotherStageInMidJobCostsTheArm) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(20));
  cell_.stage.Fail(intaglio_MOTION_WRONG_CONTROLLER, kStageRefusal);
  cell_.StepFor(3s);
  const std::size_t cracks = cell_.laser.cracks().size();
  ASSERT_LT(cracks, cell_.points_mm.size());
  cell_.RenewGrant();
  cell_.StepFor(3s);
  ExpectHalted(kStageRefusal, cracks);
  EXPECT_EQ(cell_.laser.shutters(), 0);
  cell_.stage.Fail(intaglio_MOTION_OK, "");  // the right one is back
  cell_.RenewGrant();
  cell_.StepFor(3s);
  EXPECT_EQ(cell_.laser.cracks().size(), cracks);
  GoOnToTheEnd();
}

TEST_F(EngravingDevice, AnotherStageBeforeTheFirstRunCostsTheArm) {
  cell_.stage.Fail(intaglio_MOTION_WRONG_CONTROLLER, kStageRefusal);
  cell_.StepFor(1000ms);
  EXPECT_EQ(cell_.engraving->message(), kStageRefusal);
  cell_.Grant();
  cell_.StepFor(3s);
  ExpectHalted(kStageRefusal, 0);
  cell_.stage.Fail(intaglio_MOTION_OK, "");
  cell_.StepFor(3s);
  EXPECT_EQ(cell_.laser.cracks().size(), 0u);
  GoOnToTheEnd();
}

// Cancelled or closed while another laser answers: it ends, with its own message.
TEST_F(EngravingDevice, AJobIsCancelledAlsoWhileAnotherLaserAnswers) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(20));
  ReplugTo("B-17");
  cell_.engraving->Stop("the job was cancelled");
  ASSERT_TRUE(cell_.StepUntilDone()) << cell_.Description();
  EXPECT_EQ(cell_.engraving->message(), "the job was cancelled");
  EXPECT_EQ(cell_.laser.shutters(), 0);
}

}  // namespace
}  // namespace intaglio::synchronizer
