// One object that is both drivers keeps what both seams ask for, and the two halves do
// not touch each other.

#include "tests/services/cell/one_controller.h"

#include <gtest/gtest.h>

#include "tests/services/cell/one_controller_rig.h"
#include "tests/services/drivers/laser_bench.h"
#include "tests/services/drivers/motion_bench.h"

namespace intaglio::cell {
namespace {

constexpr double kRateHz = OneMachine::kRateHz;

TEST(OneController, KeepsWhatAMotionDriverGuarantees) {
  for (const auto& check : drivers::MotionChecks()) {
    EXPECT_EQ(ViolationOf(check,
                          [](const std::string& serial_number) {
                            return MakeOneControllerMotionRig(serial_number);
                          }),
              "")
        << check.name;
  }
}

TEST(OneController, KeepsWhatALaserDriverGuarantees) {
  for (const auto& check : drivers::LaserChecks()) {
    EXPECT_EQ(ViolationOf(check,
                          [](const std::string& serial_number) {
                            return MakeOneControllerLaserRig(serial_number);
                          }),
              "")
        << check.name;
  }
}

class Both : public ::testing::Test {
 protected:
  void StepFor(int ms) {
    for (int i = 0; i < ms; ++i) {
      machine.Advance();
      motion.Poll();
      laser.Poll([](const auto&) {}, [](const auto&) {});
    }
  }
  void Prepare() {
    StepFor(10);
    ASSERT_TRUE(laser.Lamp(true, kRateHz));
    ASSERT_TRUE(laser.OpenShutters(1));
    StepFor(200);
    ASSERT_TRUE(laser.Has(link::kLampWarm));
  }

  OneMachine machine{StageOfOne(), LaserOfOne()};
  OneController both{machine, kOneSerialNumber};
  drivers::MotionDriver& motion = both;
  drivers::LaserController& laser = both;
};

// Every tick is armed; the stage's output lets those through at which a point is reached.
TEST_F(Both, FiresWhereTheMotionIsInPlace) {
  Prepare();
  const std::uint64_t start = motion.state().tick + 20;
  std::vector<motion::Segment> course = {drivers::To(0.25, 10, 5)};
  for (int i = 1; i <= 5; ++i) course.push_back(drivers::To(0.25 + 0.1 * i, 10, 1));
  course[1].pulse = course[3].pulse = true;
  course.push_back(drivers::To(1, 0, 5, true));
  ASSERT_TRUE(motion.BeginRun(1, start, 0));
  ASSERT_TRUE(motion.Append(course, {}));
  ASSERT_TRUE(laser.Arm({start, true, std::vector<bool>(30, true), false, 30}));
  StepFor(600);
  EXPECT_EQ(machine.fired_ticks(), (std::vector<std::uint64_t>{start + 6, start + 8}));
  EXPECT_EQ(laser.status().pulse_count, 2u);
}

// The bridge clears a fault before every run: a stop of the laser has to outlast that.
TEST_F(Both, ClearingAMotionFaultReleasesNoStop) {
  Prepare();
  ASSERT_TRUE(laser.Stop());
  ASSERT_TRUE(motion.BeginRun(1, 1, 0));
  StepFor(10);
  ASSERT_EQ(motion.state().fault, intaglio_MOTION_LATE);
  ASSERT_TRUE(motion.ClearFault());
  StepFor(10);
  EXPECT_EQ(motion.state().fault, intaglio_MOTION_OK);
  EXPECT_FALSE(laser.Has(link::kStopReleased));
  ASSERT_TRUE(laser.OpenShutters(1));
  ASSERT_TRUE(laser.Arm({laser.status().tick + 5, false, {true}, false, 30}));
  StepFor(200);
  EXPECT_TRUE(machine.fired_ticks().empty());
  ASSERT_TRUE(laser.Reset());
  StepFor(10);
  EXPECT_TRUE(laser.Has(link::kStopReleased));
}

}  // namespace
}  // namespace intaglio::cell
