// The rows of M17 and L14, stops at a controller, find each fault of planted_stops.h on
// each driver: a row that a fault passes at all instants checks nothing. Faults of motion
// by hand are found by what happens in a jog.

#include "tests/services/drivers/planted/planted_stops.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

#include "tests/services/drivers/laser_conformance.h"
#include "tests/services/drivers/motion_conformance.h"
#include "tests/services/drivers/planted/planted_protocols.h"
#include "tests/services/drivers/planted/planted_rigs.h"

namespace intaglio::drivers {
namespace {

bool Concerns(StopRows rows, ControllerFault fault) {
  return rows == StopRows::kAll ||
         (rows == StopRows::kLine) == (fault == ControllerFault::kUnplug);
}

/// The rows that pass; `inflicts`: whether a controller of this family has such a stop.
template <typename Check, typename Finds, typename Inflicts>
std::vector<std::string> Blind(const std::vector<Check>& checks, StopRows rows,
                               const Finds& finds, const Inflicts& inflicts) {
  std::vector<std::string> blind;
  for (const ControllerFault fault : kControllerFaults) {
    if (!Concerns(rows, fault) || !inflicts(fault)) continue;
    const std::string row = fmt::format("_{}_", NameOf(fault));
    const bool found = std::ranges::any_of(checks, [&](const Check& check) {
      return check.name.find(row) != std::string::npos && finds(check);
    });
    if (!found) blind.emplace_back(NameOf(fault));
  }
  return blind;
}

template <typename Param>
std::string NameOfStop(const Param& param) {
  std::string name = std::get<0>(param.param) + "_" + std::get<1>(param.param).name;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

class MotionStopPlanted
    : public ::testing::TestWithParam<std::tuple<std::string, MotionStopFault>> {};

TEST_P(MotionStopPlanted, IsFoundInEveryRow) {
  const auto& [protocol, fault] = GetParam();
  if (fault.in_a_jog && !Jogs(protocol)) GTEST_SKIP() << protocol << " does not jog";
  const MotionRigMaker make = PlantedMotionRigs(protocol, fault.plant);
  const auto inflicts = [&protocol = protocol](ControllerFault one) {
    return MakeMotionRig(protocol)->Inflict(one);
  };
  const auto finds = [&make](const MotionCheck& check) {
    return !ViolationOf(check, make).empty();
  };
  std::vector<MotionCheck> checks = MotionFaultChecks();
  if (fault.in_a_jog) {
    std::erase_if(checks, [](const MotionCheck& check) {
      return !check.name.ends_with(NameOf(FaultInstant::kInAJog));
    });
  }
  EXPECT_EQ(Blind(checks, fault.rows, finds, inflicts), std::vector<std::string>{});
}

INSTANTIATE_TEST_SUITE_P(
    On, MotionStopPlanted,
    ::testing::Combine(::testing::ValuesIn(MotionProtocols()),
                       ::testing::ValuesIn(MotionStopFaults().begin(),
                                           MotionStopFaults().end())),
    [](const auto& param) { return NameOfStop(param); });

// What the rows find is the fault, not the wrapper.
TEST(StopWrapper, IsFoundByNoRow) {
  for (const std::string& protocol : MotionProtocols()) {
    const MotionRigMaker make = PlantedMotionRigs(protocol, PlantNothing);
    for (const MotionCheck& check : MotionFaultChecks())
      EXPECT_EQ(ViolationOf(check, make), "") << protocol << ' ' << check.name;
  }
  for (const std::string& protocol : LaserProtocols()) {
    const LaserRigMaker make = PlantedLaserRigs(protocol, PlantNothing);
    for (const LaserCheck& check : LaserFaultChecks()) {
      EXPECT_EQ(ViolationOf(check, make),
                MakeLaserRig(protocol)->stated_violation(check.name))
          << protocol << ' ' << check.name;
    }
  }
}

class LaserStopPlanted
    : public ::testing::TestWithParam<std::tuple<std::string, LaserStopFault>> {};

TEST_P(LaserStopPlanted, IsFoundInEveryRow) {
  const auto& [protocol, fault] = GetParam();
  const LaserRigMaker make = PlantedLaserRigs(protocol, fault.plant);
  const auto inflicts = [&protocol = protocol](ControllerFault one) {
    return MakeLaserRig(protocol)->Inflict(one);
  };
  const auto finds = [&](const LaserCheck& check) {
    const std::string found = ViolationOf(check, make);
    return !found.empty() &&
           found != MakeLaserRig(protocol)->stated_violation(check.name);
  };
  EXPECT_EQ(Blind(LaserFaultChecks(), fault.rows, finds, inflicts),
            std::vector<std::string>{});
}

INSTANTIATE_TEST_SUITE_P(On, LaserStopPlanted,
                         ::testing::Combine(::testing::ValuesIn(LaserProtocols()),
                                            ::testing::ValuesIn(LaserStopFaults().begin(),
                                                                LaserStopFaults().end())),
                         [](const auto& param) { return NameOfStop(param); });

}  // namespace
}  // namespace intaglio::drivers
