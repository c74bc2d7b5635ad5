// Each planted fault is found on each driver: by the checks of every driver, or where the
// family states that it cannot keep a guarantee, by the checks of what holds instead.

#include "tests/services/drivers/planted/planted_faults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <tuple>

#include "tests/services/drivers/laser_conformance.h"
#include "tests/services/drivers/motion_conformance.h"
#include "tests/services/drivers/planted/grbl_checks.h"
#include "tests/services/drivers/planted/planted_protocols.h"
#include "tests/services/drivers/planted/planted_rigs.h"

namespace intaglio::drivers {
namespace {

/// The check that is named for a fault first.
template <typename Check>
std::vector<Check> InOrder(std::span<const Check> checks, std::string_view first) {
  std::vector<Check> all(checks.begin(), checks.end());
  std::stable_partition(all.begin(), all.end(),
                        [&](const Check& check) { return check.name == first; });
  EXPECT_EQ(all.front().name, first) << "there is no such check";
  return all;
}

class MotionPlanted
    : public ::testing::TestWithParam<std::tuple<std::string, MotionFault>> {};

TEST_P(MotionPlanted, IsFound) {
  const auto& [protocol, fault] = GetParam();
  if (fault.by_hand && !Jogs(protocol)) GTEST_SKIP() << protocol << " does not jog";
  if (fault.draws && !DrawsOutlines(protocol))
    GTEST_SKIP() << protocol << " draws no outlines";
  if (fault.carries && !CarriesABlock(protocol))
    GTEST_SKIP() << protocol << " carries no block";
  const MotionRigMaker make = PlantedMotionRigs(protocol, fault.plant);
  std::string found;
  for (const MotionCheck& check : InOrder(MotionChecks(), fault.check)) {
    found = ViolationOf(check, make);
    if (!found.empty()) break;
  }
  EXPECT_NE(found, "");
  std::cout << "  " << found << "\n";
}

template <typename Param>
std::string NameOf(const Param& param) {
  std::string name = std::get<0>(param.param) + "_" + std::get<1>(param.param).name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(On, MotionPlanted,
                         ::testing::Combine(::testing::ValuesIn(MotionProtocols()),
                                            ::testing::ValuesIn(MotionFaults().begin(),
                                                                MotionFaults().end())),
                         [](const auto& param) { return NameOf(param); });

class LaserPlanted
    : public ::testing::TestWithParam<std::tuple<std::string, LaserFault>> {};

std::string FoundByGrblChecks(const LaserFault& fault) {
  for (const GrblCheck& check : GrblChecks()) {
    if (auto found = ViolationOf(check, fault.plant); !found.empty()) return found;
  }
  return "";
}

TEST_P(LaserPlanted, IsFound) {
  const auto& [protocol, fault] = GetParam();
  const LaserRigMaker make = PlantedLaserRigs(protocol, fault.plant);
  std::string found;
  for (const LaserCheck& check : InOrder(LaserChecks(), fault.check)) {
    found = ViolationOf(check, make);
    if (!found.empty() && found != MakeLaserRig(protocol)->stated_violation(check.name))
      break;
    found.clear();
  }
  if (found.empty() && protocol == "grbl") found = FoundByGrblChecks(fault);
  EXPECT_NE(found, "");
  std::cout << "  " << found << "\n";
}

INSTANTIATE_TEST_SUITE_P(On, LaserPlanted,
                         ::testing::Combine(::testing::ValuesIn(LaserProtocols()),
                                            ::testing::ValuesIn(LaserFaults().begin(),
                                                                LaserFaults().end())),
                         [](const auto& param) { return NameOf(param); });

TEST(GrblChecks, AreKeptByTheGoodDriver) {
  for (const GrblCheck& check : GrblChecks()) EXPECT_EQ(ViolationOf(check), "");
}

}  // namespace
}  // namespace intaglio::drivers
