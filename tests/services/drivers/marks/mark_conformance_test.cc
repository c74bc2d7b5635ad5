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

class MarkPlanted : public ::testing::TestWithParam<std::tuple<std::string, MarkFault>> {
};

TEST_P(MarkPlanted, IsFound) {
  const auto& [rig, fault] = GetParam();
  if (fault.of_tools_with_axes && MakeMarkRig(rig)->driver->hand() == nullptr)
    GTEST_SKIP() << rig << " has no such fault";
  if (fault.of_known_power_ups && !MakeMarkRig(rig)->knows_power_ups())
    GTEST_SKIP() << rig << " counts each lost line";
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
