// A profile against a machine that runs: the virtual engraver, over its real lines.

#include "services/client/machine/device_comparison.h"

#include <gmock/gmock.h>

#include "services/job/files/job_file.h"
#include "tests/services/virtual_engraver/engraver_process.h"
#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

MachineSpec Els03() {
  return ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto").value();
}

std::string TextOf(const std::vector<Error>& errors) {
  std::string text;
  for (const Error& error : errors) text += error.message + "\n";
  return text;
}

link::LaserIdentity GoodLaser() {
  link::LaserIdentity laser;
  laser.channels = 4;
  laser.rates_hz = {1, 2, 5, 10, 25, 50, 100, 200};
  laser.serial_number = "L-1";
  laser.min_energy_mj = 1;
  laser.max_energy_mj = 30;
  laser.locks_door = true;
  return laser;
}

link::MotionIdentity GoodStage() {
  link::MotionIdentity stage;
  for (int axis = 0; axis < 3; ++axis) {
    stage.travel_min_nm[axis] = -2'000'000;
    stage.travel_max_nm[axis] = 172'000'000;
  }
  stage.serial_number = "S-1";
  return stage;
}

TEST(DeviceComparison, WhatAgreesIsNoDifference) {
  MachineSpec machine = Els03();
  EXPECT_THAT(CompareLaser(machine, GoodLaser()), IsEmpty());
  EXPECT_THAT(CompareStage(machine, GoodStage(), link::StageTolerance{30000}), IsEmpty());
  EXPECT_THAT(CompareStage(machine, GoodStage(), std::nullopt), IsEmpty());
  machine.mutable_laser_line()->set_serial_number("L-1");
  machine.mutable_motion_line()->set_serial_number("S-1");
  EXPECT_THAT(CompareLaser(machine, GoodLaser()), IsEmpty());
  EXPECT_THAT(CompareStage(machine, GoodStage(), std::nullopt), IsEmpty());
}

TEST(DeviceComparison, NamesAnAxisThatIsFasterThanItsSteps) {
  MachineSpec machine = Els03();
  const link::StageTolerance tolerance{30000};
  link::StageSpeed speed{80000000, 80000000, 80000000};
  EXPECT_THAT(CompareStage(machine, GoodStage(), tolerance, speed), IsEmpty());
  speed.y_counts = 75000000;
  EXPECT_THAT(TextOf(CompareStage(machine, GoodStage(), tolerance, speed)),
              HasSubstr("y.max_speed_mm_s: 80 mm/s is faster than the stage controller "
                        "can step this axis; reduce it to at most 75 mm/s"));
}

TEST(DeviceComparison, OutputsAndInputsAreOfTheLaserLineThatServesThem) {
  MachineSpec machine = Els03();
  machine.add_inputs()->set_name("clamp");
  EXPECT_THAT(CheckDriversOf(machine), IsEmpty());
  machine.mutable_laser_line()->set_protocol("motion-output");
  machine.mutable_motion_line()->set_protocol("isel");
  EXPECT_THAT(TextOf(CheckDriversOf(machine)),
              HasSubstr("inputs: a laser_line of the protocol 'motion-output' serves no "
                        "outputs and no inputs for other uses"));
  machine.clear_inputs();
  EXPECT_THAT(CheckDriversOf(machine), IsEmpty());
}

TEST(DeviceComparison, OutputsAndInputsThatTheControllerDoesNotHaveAreNamed) {
  MachineSpec machine = Els03();
  machine.add_outputs()->set_output(2);
  machine.add_inputs()->set_input(3);
  EXPECT_THAT(CompareLaser(machine, GoodLaser(), {2, 3, 0, 0}), IsEmpty());
  const std::string found = TextOf(CompareLaser(machine, GoodLaser(), {1, 2, 0, 0}));
  EXPECT_THAT(found, HasSubstr("outputs[0].output: 2 is above the 1 that the laser"));
  EXPECT_THAT(found, HasSubstr("inputs[0].input: 3 is above the 2 that the laser"));
}

TEST(DeviceComparison, EachDifferenceNamesItsField) {
  MachineSpec machine = Els03();
  machine.mutable_laser_line()->set_serial_number("L-2");
  machine.mutable_motion_line()->set_serial_number("S-2");
  machine.set_pulse_trigger(PULSE_TRIGGER_AT_PLACE);
  link::LaserIdentity laser = GoodLaser();
  laser.channels = 2;
  laser.rates_hz.pop_back();
  laser.max_energy_mj = 29;
  for (const double mj : {0.5, 30.0}) {
    EnergyPoint& point = *machine.mutable_laser()->add_energy_calibration();
    point.set_energy_mj(mj);
    point.set_setting_ratio(mj / 30);
  }
  const std::string of_laser = TextOf(CompareLaser(machine, laser));
  EXPECT_THAT(of_laser, HasSubstr("laser_line.serial_number: \"L-2\" is expected"));
  EXPECT_THAT(of_laser, HasSubstr("laser.channels: 4 are more than the 2"));
  EXPECT_THAT(of_laser, HasSubstr("laser.rates_hz[7]: 200 Hz is no rate"));
  EXPECT_THAT(of_laser, HasSubstr("laser.pulse_energy_mj: 30 mJ are above the 29 mJ"));
  EXPECT_THAT(of_laser, HasSubstr("laser.energy_calibration[0].energy_mj: 0.5 mJ are "
                                  "below the 1 mJ"));
  EXPECT_THAT(of_laser, HasSubstr("pulse_trigger: "));
  link::MotionIdentity stage = GoodStage();
  stage.travel_max_nm[1] = 150'000'000;
  const std::string of_stage =
      TextOf(CompareStage(machine, stage, link::StageTolerance{10000}));
  EXPECT_THAT(of_stage, HasSubstr("motion_line.serial_number: \"S-2\" is expected"));
  EXPECT_THAT(of_stage, HasSubstr("y travel: -2 to 172 mm is beyond the -2 to 150"));
  EXPECT_THAT(of_stage, HasSubstr("position_tolerance_um: "));
  EXPECT_THAT(of_stage, HasSubstr("pulse_trigger: "));
}

TEST(DeviceComparison, ReadsARunningMachineAndLeavesABusyOneAlone) {
  virtual_engraver::EngraverProcess engraver(
      test::FreshFolder(),
      "laser { inputs: true } stage { travel_max_mm { x: 100 y: 172 z: 172 } }");
  ASSERT_TRUE(engraver.AwaitReady());
  MachineSpec machine = Els03();
  machine.mutable_laser_line()->set_device(engraver.laser_line());
  machine.mutable_motion_line()->set_device(engraver.motion_line());
  for (const std::uint32_t number : {1u, 2u}) machine.add_inputs()->set_input(number);
  {
    const auto found = CompareDevices(machine, link::MonotonicClock());
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].not_compared, "");
    EXPECT_EQ(found[1].not_compared, "");
    EXPECT_THAT(TextOf(found[1].differences), HasSubstr("x travel: -2 to 172 mm"));
    EXPECT_THAT(TextOf(found[0].differences), HasSubstr("inputs[1].input: 2 is above"));
    EXPECT_THAT(TextOf(found[0].differences), Not(HasSubstr("inputs[0].input")));
  }
  virtual_engraver::EngravingHost host(engraver);
  ASSERT_TRUE(host.Connect());
  const auto busy = CompareDevices(machine, link::MonotonicClock());
  EXPECT_NE(busy[0].not_compared, "");
  EXPECT_NE(busy[1].not_compared, "");
  EXPECT_TRUE(host.Until([] { return true; }));
}

}  // namespace
}  // namespace intaglio::client
