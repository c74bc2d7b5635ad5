#include "tests/services/drivers/motion_conformance.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "services/drivers/motion_drivers.h"

namespace intaglio::drivers {
namespace {

std::vector<std::string> Protocols() {
  std::vector<std::string> all;
  // In real time, by linuxcnc_driver_test: linuxcnc.
  for (const MotionDriverKind& kind : MotionDriverKinds())
    if (kind.protocol != "linuxcnc") all.emplace_back(kind.protocol);
  return all;
}

class EveryMotionDriver
    : public ::testing::TestWithParam<std::tuple<std::string, MotionCheck>> {};

TEST_P(EveryMotionDriver, Keeps) {
  const auto& [protocol, check] = GetParam();
  ASSERT_NE(MakeMotionRig(protocol), nullptr) << "no family has a row for it (rig_row.h)";
  const MotionRigMaker make = [&protocol = protocol](const std::string& serial_number) {
    return MakeMotionRig(protocol, serial_number);
  };
  EXPECT_EQ(ViolationOf(check, make), "");
}

INSTANTIATE_TEST_SUITE_P(Of, EveryMotionDriver,
                         ::testing::Combine(::testing::ValuesIn(Protocols()),
                                            ::testing::ValuesIn(MotionChecks().begin(),
                                                                MotionChecks().end())),
                         [](const auto& param) {
                           std::string name = std::get<0>(param.param);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name + "_" + std::get<1>(param.param).name;
                         });

}  // namespace
}  // namespace intaglio::drivers
