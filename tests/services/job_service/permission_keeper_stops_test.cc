// The emergency stops that the job service reads, and what it reports of them.

#include <gtest/gtest.h>

#include "services/job_service/permission_keeper.h"
#include "services/platform/bus/samples.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;
using StopStates = std::vector<std::pair<std::string, bool>>;

const std::string kCell = "els-03";

class PermissionKeeperStops : public ::testing::Test {
 protected:
  PermissionKeeperStops() { keeper_.Open(kCell, {}); }

  void Write(const std::string& source, bool pressed,
             const std::vector<host::StopPress>& released) {
    const auto wire = host::WireOf(released);
    intaglio_EmergencyStop sample{};
    sample.cell = sample.operator_name = sample.reason = bus::Borrow(kCell);
    sample.source = bus::Borrow(source);
    sample.number = 1;
    sample.pressed = pressed;
    bus::Borrow(sample.released, wire);
    ASSERT_TRUE(test::Eventually([&] { return stops_.matched_count() == 1; }));
    ASSERT_TRUE(stops_.Write(sample));
    ASSERT_TRUE(stops_.WaitForAcknowledgements(5s));
  }

  bus::Bus bus_{test::PrivateBusOptions()};
  bus::Writer<intaglio_EmergencyStop> stops_{bus_, bus::kEmergencyStop, "*"};
  PermissionKeeper keeper_{bus_};
};

// A job service that was late for a moment disarms the job all the same.
TEST_F(PermissionKeeperStops, AResetThatIsReadWithItsPressDoesNotHideIt) {
  Write("bob", false, {{"ann", 1}});
  Write("ann", true, {});
  EXPECT_EQ(keeper_.TakeStops(), (StopStates{{kCell, true}}));
  EXPECT_EQ(keeper_.TakeStops(), (StopStates{{kCell, false}}));
}

// The command that pressed it may end before this process has discovered it.
TEST_F(PermissionKeeperStops, APressThatOnlyTheMachineReceivedIsItsTooUntilAReset) {
  keeper_.TakePresses(kCell, {{"ann", 1}});
  EXPECT_EQ(keeper_.TakeStops(), (StopStates{{kCell, true}}));
  Write("bob", false, {{"ann", 1}});
  EXPECT_EQ(keeper_.TakeStops(), (StopStates{{kCell, false}}));
  // What the machine reported before the reset reached it, too.
  keeper_.TakePresses(kCell, {{"ann", 1}});
  EXPECT_EQ(keeper_.TakeStops(), (StopStates{{kCell, false}}));
}

TEST_F(PermissionKeeperStops, WhatItHoldsIsInThePermission) {
  bus::Reader<intaglio_Permission> permissions(bus_, bus::kPermission, kCell);
  Write("ann", true, {});
  EXPECT_EQ(keeper_.TakeStops(), (StopStates{{kCell, true}}));
  std::vector<host::StopPress> held;
  EXPECT_TRUE(test::Eventually([&] {
    keeper_.Decide({});
    permissions.Take([&](const intaglio_Permission& sample) {
      held.clear();
      for (const intaglio_StopPress& press : bus::View(sample.bus_stops))
        held.push_back({press.source, press.number});
    });
    return held == std::vector<host::StopPress>{{"ann", 1}};
  }));
  Write("bob", false, {{"ann", 1}});
  EXPECT_EQ(keeper_.TakeStops(), (StopStates{{kCell, false}}));
}

}  // namespace
}  // namespace intaglio::job_service
