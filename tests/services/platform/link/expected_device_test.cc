#include "services/platform/link/expected_device.h"

#include <gtest/gtest.h>

namespace intaglio::link {
namespace {

const ExpectedDevice kLaser{"A-03", "laser", "els-03", "/dev/ttyUSB0", "laser_line"};

TEST(ExpectedDevice, AcceptsItsSerialNumberAndNoOther) {
  EXPECT_EQ(RefusalOf(kLaser, "A-03"), "");
  EXPECT_NE(RefusalOf(kLaser, "a-03"), "");
  EXPECT_NE(RefusalOf(kLaser, "A-03 "), "");
  EXPECT_NE(RefusalOf(kLaser, "A-0"), "");
}

TEST(ExpectedDevice, NamesBothTheDeviceAndTheRemedy) {
  EXPECT_EQ(
      RefusalOf(kLaser, "B-17"),
      "the line at /dev/ttyUSB0 leads to laser 'B-17', the profile of els-03 expects "
      "'A-03': swap the cables or correct laser_line.serial_number");
  EXPECT_EQ(RefusalOf(kLaser, ""),
            "the line at /dev/ttyUSB0 leads to a laser without a serial number, the "
            "profile of els-03 expects 'A-03': swap the cables or correct "
            "laser_line.serial_number");
}

TEST(ExpectedDevice, WithoutASerialNumberAcceptsEveryDevice) {
  ExpectedDevice any = kLaser;
  any.serial_number.clear();
  EXPECT_EQ(RefusalOf(any, "B-17"), "");
  EXPECT_EQ(RefusalOf(any, ""), "");
}

TEST(ExpectedDevice, AsksForTheVersionOfTheFrames) {
  EXPECT_EQ(kLaser.VersionHint(),
            "the laser at /dev/ttyUSB0 must use version 13 of the frames "
            "(docs/protocols.md)");
}

}  // namespace
}  // namespace intaglio::link
