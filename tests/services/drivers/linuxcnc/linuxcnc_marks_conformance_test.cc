// The guarantees of every driver of marks, on LinuxCNC with a beam; and planted faults,
// which its checks find there.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "tests/services/drivers/linuxcnc/linuxcnc_mark_rig.h"
#include "tests/services/drivers/marks/mark_conformance.h"
#include "tests/services/drivers/marks/planted_marks.h"

namespace intaglio::linuxcnc {
namespace {

bool IsOneOfMany(const std::string& check) {
  const bool of_faults = check.starts_with("K9K10_") || check.starts_with("K12_");
  return of_faults && check != "K9K10_unplug_in_the_run" &&
         check != "K9K10_power_cycle_behind_the_run" &&
         check != "K9K10_emergency_stop_in_the_run" && check != "K9K10_alarm_in_the_run";
}

std::string WhyNot(const std::string& check) {
  if (IsOneOfMany(check) && std::getenv("INTAGLIO_LONG") == nullptr)
    return "is one of many in real time: set INTAGLIO_LONG=1";
  return EnterNamespace();
}

/// LinuxCNC runs in real time, here on a kernel that has none: a run whose rows came late
/// says that the computer is too busy. It is made again then, twice at most.
std::string ViolationInTime(const drivers::MarkCheck& check) {
  constexpr int kRuns = 3;
  std::string violation;
  for (int run = 0; run < kRuns; ++run) {
    violation = drivers::ViolationOf(check, &MakeBeamRig);
    if (violation.find("too busy") == std::string::npos) break;
  }
  return violation;
}

class LinuxcncMarks : public ::testing::TestWithParam<drivers::MarkCheck> {};

TEST_P(LinuxcncMarks, Keeps) {
  if (const auto why = WhyNot(GetParam().name); !why.empty()) GTEST_SKIP() << why;
  EXPECT_EQ(ViolationInTime(GetParam()), "");
}

INSTANTIATE_TEST_SUITE_P(Of, LinuxcncMarks, ::testing::ValuesIn(drivers::MarkChecks()),
                         [](const auto& check) { return check.param.name; });

class LinuxcncMarksPlanted : public ::testing::TestWithParam<drivers::MarkFault> {};

TEST_P(LinuxcncMarksPlanted, IsFound) {
  const drivers::MarkFault& fault = GetParam();
  if (fault.of != drivers::FaultOf::kAll)
    GTEST_SKIP() << "LinuxCNC with a beam cannot have this fault";
  if (const auto why = EnterNamespace(); !why.empty()) GTEST_SKIP() << why;
  std::string found;
  for (const drivers::MarkCheck& check : drivers::MarkChecks()) {
    if (!check.name.starts_with(fault.check) || !found.empty()) continue;
    found = drivers::ViolationOf(check, [&](const std::string& serial_number) {
      auto rig = MakeBeamRig(serial_number);
      rig->driver = fault.plant(std::move(rig->driver));
      return rig;
    });
  }
  EXPECT_NE(found, "");
  std::cout << "  " << found << "\n";
}

INSTANTIATE_TEST_SUITE_P(On, LinuxcncMarksPlanted,
                         ::testing::ValuesIn(drivers::MarkFaults().begin(),
                                             drivers::MarkFaults().end()),
                         [](const auto& fault) { return std::string(fault.param.name); });

}  // namespace
}  // namespace intaglio::linuxcnc
