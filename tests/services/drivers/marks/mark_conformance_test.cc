#include "tests/services/drivers/marks/mark_conformance.h"

#include <gtest/gtest.h>

#include <tuple>

#include "services/drivers/mark_drivers.h"
#include "tests/services/drivers/marks/planted_marks.h"

namespace intaglio::drivers {
namespace {

std::vector<std::string> Rigs() {
  std::vector<std::string> all;
  for (const MarkDriverKind& kind : MarkDriverKinds()) {
    // In real time, with LinuxCNC itself: linuxcnc_marks_test.
    if (kind.protocol == "linuxcnc-course") continue;
    const auto rigs = MarkRigsOf(kind.protocol);
    EXPECT_FALSE(rigs.empty()) << "no family has a row (rig_row.h) for " << kind.protocol;
    all.insert(all.end(), rigs.begin(), rigs.end());
  }
  return all;
}

MarkRigMaker MakerOf(const std::string& name, const MarkFault* fault = nullptr) {
  return [name, fault](const std::string& serial_number) {
    auto rig = MakeMarkRig(name, serial_number);
    if (fault != nullptr) rig->driver = fault->plant(std::move(rig->driver));
    return rig;
  };
}

class EveryMarkDriver
    : public ::testing::TestWithParam<std::tuple<std::string, MarkCheck>> {};

TEST_P(EveryMarkDriver, Keeps) {
  const auto& [rig, check] = GetParam();
  EXPECT_EQ(ViolationOf(check, MakerOf(rig)), "");
}

INSTANTIATE_TEST_SUITE_P(Of, EveryMarkDriver,
                         ::testing::Combine(::testing::ValuesIn(Rigs()),
                                            ::testing::ValuesIn(MarkChecks())),
                         [](const auto& param) {
                           return std::get<0>(param.param) + "_" +
                                  std::get<1>(param.param).name;
                         });

bool CanHave(const MarkFault& fault, MarkRig& rig) {
  switch (fault.of) {
    case FaultOf::kToolsWithAxes:
      return rig.can_lose_place();
    case FaultOf::kKnownPowerUps:
      return rig.knows_power_ups();
    case FaultOf::kGuideLasers:
      return rig.place_tolerance_mm() > 0;
    case FaultOf::kAll:
      break;
  }
  return true;
}

class MarkPlanted : public ::testing::TestWithParam<std::tuple<std::string, MarkFault>> {
};

TEST_P(MarkPlanted, IsFound) {
  const auto& [rig, fault] = GetParam();
  if (!CanHave(fault, *MakeMarkRig(rig)))
    GTEST_SKIP() << rig << " cannot have this fault";
  std::string found;
  for (const MarkCheck& check : MarkChecks()) {
    if (check.name.starts_with(fault.check))
      found = ViolationOf(check, MakerOf(rig, &fault));
    if (!found.empty()) break;
  }
  EXPECT_NE(found, "");
}

INSTANTIATE_TEST_SUITE_P(On, MarkPlanted,
                         ::testing::Combine(::testing::ValuesIn(Rigs()),
                                            ::testing::ValuesIn(MarkFaults().begin(),
                                                                MarkFaults().end())),
                         [](const auto& param) {
                           return std::get<0>(param.param) + "_" +
                                  std::get<1>(param.param).name;
                         });

}  // namespace
}  // namespace intaglio::drivers
