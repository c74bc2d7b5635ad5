// How often a machine at rest wakes up and speaks, by a clock that jumps from one thing
// that it waits for to the next: what an idle cell costs.

#include <gmock/gmock.h>

#include "tests/services/virtual_engraver/machine_bench.h"

namespace intaglio::virtual_engraver {
namespace {

using namespace std::chrono_literals;
using link::LaserFrame;

class RestingMachine : public MachineBench {
 protected:
  void SetUp() override {
    Start(PlainOptions(false));
    Connect();
  }
  /// Turns of the machine in this time: when it wants one, and when a host has sent.
  int Turns(std::chrono::nanoseconds time) {
    int turns = 0;
    for (const auto end = now + time; now < end;) {
      now += machine->Turn();
      ++turns;
      const auto take = [this](std::uint8_t type, std::span<const std::byte> payload) {
        received.Receive(type, payload);
      };
      EXPECT_TRUE(laser_host->Poll(take) && motion_host->Poll(take));
    }
    return turns;
  }
};

// Both hosts are polled at the moment of the statuses, so that their acknowledgements are
// there when the machine turns for the next ones.
TEST_F(RestingMachine, TurnsForItsStatusesAlone) {
  received = {};
  const int turns = Turns(10s);
  constexpr int kStatuses = 10'000 / 40;
  EXPECT_NEAR(turns, kStatuses, 1);
  EXPECT_NEAR(static_cast<double>(received.laser_statuses.size()), kStatuses, 1);
  EXPECT_NEAR(static_cast<double>(received.motion_statuses.size()), kStatuses, 1);
  EXPECT_TRUE(laser_host->up() && motion_host->up());
}

// What begins is reported at once, and what goes on twice as often.
TEST_F(RestingMachine, WakesForAHostAndReportsAtOnce) {
  Turns(1s);
  SendLaser(LaserFrame::kLampCommand, Encode(link::LampCommand{true, 100}));
  EXPECT_TRUE(laser_host->Poll([](auto, auto) {}));
  received = {};
  machine->Turn();
  EXPECT_TRUE(laser_host->Poll(
      [this](auto type, auto payload) { received.Receive(type, payload); }));
  ASSERT_FALSE(received.laser_statuses.empty());
  EXPECT_TRUE(received.laser_statuses.back().interlocks & link::kLampOn);
  received = {};
  Turns(10s);
  EXPECT_GE(received.laser_statuses.size(), 10'000u / 30);
  EXPECT_LE(received.laser_statuses.size(), 10'000u / 20 + 1);
}

}  // namespace
}  // namespace intaglio::virtual_engraver
