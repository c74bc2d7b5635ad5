// Each planted fault is found on LinuxCNC, too: by the check that is named for it.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iostream>
#include <string>

#include "tests/services/drivers/laser_conformance.h"
#include "tests/services/drivers/linuxcnc/linuxcnc_rig.h"
#include "tests/services/drivers/motion_conformance.h"
#include "tests/services/drivers/planted/planted_faults.h"

namespace intaglio::linuxcnc {
namespace {

template <typename Check>
const Check& Named(std::span<const Check> checks, std::string_view name) {
  return *std::find_if(checks.begin(), checks.end(),
                       [&](const Check& check) { return check.name == name; });
}

// In real time: a computer that is busy may end the session before the fault shows, and
// a driver without a session fires nothing.
std::string FindInTries(const std::function<std::string()>& check) {
  std::string found;
  for (int i = 0; i < 3 && found.empty(); ++i) found = check();
  return found;
}

class LinuxcncMotionPlanted : public ::testing::TestWithParam<drivers::MotionFault> {};

TEST_P(LinuxcncMotionPlanted, IsFound) {
  if (GetParam().draws) GTEST_SKIP() << "LinuxCNC draws no outlines";
  if (GetParam().carries) GTEST_SKIP() << "LinuxCNC moves no stage that carries a block";
  if (const auto why = EnterNamespace(); !why.empty()) GTEST_SKIP() << why;
  const auto found = FindInTries([] {
    return drivers::ViolationOf(Named(drivers::MotionChecks(), GetParam().check),
                                [](const std::string& serial) {
                                  auto rig = MakeMotionRig(serial);
                                  rig->driver = GetParam().plant(std::move(rig->driver));
                                  return rig;
                                });
  });
  EXPECT_NE(found, "");
  std::cout << "  " << found << "\n";
}

INSTANTIATE_TEST_SUITE_P(On, LinuxcncMotionPlanted,
                         ::testing::ValuesIn(drivers::MotionFaults().begin(),
                                             drivers::MotionFaults().end()),
                         [](const auto& fault) { return std::string(fault.param.name); });

class LinuxcncLaserPlanted : public ::testing::TestWithParam<drivers::LaserFault> {};

TEST_P(LinuxcncLaserPlanted, IsFound) {
  if (const auto why = EnterNamespace(); !why.empty()) GTEST_SKIP() << why;
  const auto found = FindInTries([] {
    return drivers::ViolationOf(Named(drivers::LaserChecks(), GetParam().check),
                                [](const std::string& serial) {
                                  auto rig = MakeLaserRig(serial);
                                  rig->driver = GetParam().plant(std::move(rig->driver));
                                  return rig;
                                });
  });
  EXPECT_NE(found, "");
  std::cout << "  " << found << "\n";
}

INSTANTIATE_TEST_SUITE_P(On, LinuxcncLaserPlanted,
                         ::testing::ValuesIn(drivers::LaserFaults().begin(),
                                             drivers::LaserFaults().end()),
                         [](const auto& fault) { return std::string(fault.param.name); });

}  // namespace
}  // namespace intaglio::linuxcnc
