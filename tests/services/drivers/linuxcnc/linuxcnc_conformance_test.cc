// The guarantees of every motion driver and of every laser driver, on LinuxCNC.
#include <gtest/gtest.h>

#include <cstdlib>
#include <set>
#include <string>

#include "tests/services/drivers/laser_conformance.h"
#include "tests/services/drivers/linuxcnc/linuxcnc_rig.h"
#include "tests/services/drivers/motion_conformance.h"

namespace intaglio::linuxcnc {
namespace {

/// Minutes each, in real time: with INTAGLIO_LONG=1.
const std::set<std::string> kLong = {"M9_cut_at_any_byte", "L7_cut_at_any_byte",
                                     "L6_memory"};

bool IsOneOfMany(const std::string& check) {
  const bool of_faults = check.starts_with("M17_") || check.starts_with("L14_");
  return of_faults && check != "M17_unplug_in_the_run" &&
         check != "L14_emergency_stop_in_the_run";
}

std::string WhyNot(const std::string& check) {
  if (IsOneOfMany(check) && std::getenv("INTAGLIO_LONG") == nullptr)
    return "is one of many in real time: set INTAGLIO_LONG=1";
  if (kLong.contains(check) && std::getenv("INTAGLIO_LONG") == nullptr)
    return "takes minutes: set INTAGLIO_LONG=1";
  return EnterNamespace();
}

/// LinuxCNC runs in real time, here on a kernel that has none: a run whose rows came late
/// says that the computer is too busy. It is made again then, twice at most.
template <typename Check, typename Maker>
std::string ViolationInTime(const Check& check, const Maker& make) {
  constexpr int kRuns = 3;
  std::string violation;
  for (int run = 0; run < kRuns; ++run) {
    violation = drivers::ViolationOf(check, make);
    if (violation.find("the computer is too busy") == std::string::npos) break;
  }
  return violation;
}

class LinuxcncMotion : public ::testing::TestWithParam<drivers::MotionCheck> {};

TEST_P(LinuxcncMotion, Keeps) {
  if (const auto why = WhyNot(GetParam().name); !why.empty()) GTEST_SKIP() << why;
  EXPECT_EQ(ViolationInTime(GetParam(), &MakeMotionRig), "");
}

INSTANTIATE_TEST_SUITE_P(Of, LinuxcncMotion,
                         ::testing::ValuesIn(drivers::MotionChecks().begin(),
                                             drivers::MotionChecks().end()),
                         [](const auto& check) { return std::string(check.param.name); });

class LinuxcncLaser : public ::testing::TestWithParam<drivers::LaserCheck> {};

TEST_P(LinuxcncLaser, Keeps) {
  if (const auto why = WhyNot(GetParam().name); !why.empty()) GTEST_SKIP() << why;
  EXPECT_EQ(ViolationInTime(GetParam(), &MakeLaserRig), "");
}

INSTANTIATE_TEST_SUITE_P(Of, LinuxcncLaser,
                         ::testing::ValuesIn(drivers::LaserChecks().begin(),
                                             drivers::LaserChecks().end()),
                         [](const auto& check) { return std::string(check.param.name); });

}  // namespace
}  // namespace intaglio::linuxcnc
