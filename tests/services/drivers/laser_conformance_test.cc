#include "tests/services/drivers/laser_conformance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "services/drivers/laser_drivers.h"
#include "services/drivers/motion_drivers.h"

namespace intaglio::drivers {
namespace {

std::vector<std::string> Protocols() {
  std::vector<std::string> all;
  for (const LaserDriverKind& kind : LaserDriverKinds()) all.emplace_back(kind.protocol);
  for (const MotionDriverKind& kind : MotionDriverKinds())
    // In real time, by linuxcnc_driver_test: linuxcnc.
    if (kind.switches_laser && kind.protocol != "linuxcnc")
      all.emplace_back(kind.protocol);
  return all;
}

class EveryLaserDriver
    : public ::testing::TestWithParam<std::tuple<std::string, LaserCheck>> {};

TEST_P(EveryLaserDriver, Keeps) {
  const auto& [protocol, check] = GetParam();
  ASSERT_NE(MakeLaserRig(protocol), nullptr) << "no family has a row for it (rig_row.h)";
  const LaserRigMaker make = [&protocol = protocol](const std::string& serial_number) {
    return MakeLaserRig(protocol, serial_number);
  };
  const std::string stated = MakeLaserRig(protocol)->stated_violation(check.name);
  const std::string found = ViolationOf(check, make);
  EXPECT_EQ(stated.empty() ? found : found.substr(0, stated.size()), stated) << found;
}

INSTANTIATE_TEST_SUITE_P(Of, EveryLaserDriver,
                         ::testing::Combine(::testing::ValuesIn(Protocols()),
                                            ::testing::ValuesIn(LaserChecks().begin(),
                                                                LaserChecks().end())),
                         [](const auto& param) {
                           std::string name = std::get<0>(param.param);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name + "_" + std::get<1>(param.param).name;
                         });

}  // namespace
}  // namespace intaglio::drivers
