// What the machine does by itself when its host is silent, gone or another one.

#include "tests/services/virtual_engraver/machine_bench.h"
#include "tests/services/virtual_engraver/stage_path.h"

namespace intaglio::virtual_engraver {
namespace {

using link::LaserFrame;
using link::MotionFrame;
using link::StageFault;
using namespace std::chrono_literals;

class MachineSafety : public MachineBench {
 protected:
  std::uint8_t interlocks() const { return machine->laser().Report().interlocks; }
  bool safe_state() const { return (interlocks() & link::kSafeState) != 0; }
  /// The machine received a valid frame at this very moment.
  void SendOnLaser() {
    SendLaser(LaserFrame::kLaserStatusRequest);
    Pass(1ms);
  }
  void SendOnMotion() {
    SendMotion(MotionFrame::kMotionStatusRequest);
    Pass(1ms);
  }
  /// Shutter open and far more ticks armed than a test lasts; every tick fires.
  void StartFiring(bool lockstep) {
    Start(PlainOptions(lockstep));
    Connect();
    OpenShutterAndLamp();
    const std::uint64_t first = machine->laser().tick() + 5;
    SendLaser(LaserFrame::kArmWindow,
              Encode(link::ArmWindow{first, false, std::vector<bool>(1000, true)}));
    Pass(100ms);
    ASSERT_GT(machine->laser().Report().pulse_count, 0u);
  }
  /// A run along x at 50 mm/s, 0.5 mm a tick, that lasts 100 ticks.
  void StartMoving() {
    Start(PlainOptions(false));
    Connect();
    std::vector<Knot> line = {{{250, 0, 0}, {50000, 0, 0}, kTick}};
    for (int i = 1; i < 31; ++i)
      line.push_back({{250 + i * 500.0, 0, 0}, {50000, 0, 0}, kTick});
    line.push_back({{30000, 0, 0}, {0, 0, 0}, 69 * kTick, false, true});
    SendMotion(MotionFrame::kBeginRun,
               Encode(link::BeginRun{1, machine->laser().tick() + 3}));
    SendMotion(MotionFrame::kSegments, Encode(Frame(line)));
    Pass(150ms);
    ASSERT_TRUE(machine->stage().running());
    ASSERT_GT(machine->stage().actual_mm().x(), 1);
  }
};

TEST_F(MachineSafety, QuarterOfASecondOfSilenceClosesTheShutters) {
  StartFiring(false);
  SendOnLaser();
  laser_in->cut = true;
  Pass(250ms);
  EXPECT_EQ(machine->laser().shutters(), 1);
  EXPECT_FALSE(safe_state());
  const std::uint64_t cracks = machine->glass().crack_count();
  Pass(1ms);
  EXPECT_EQ(machine->laser().shutters(), 0);
  EXPECT_TRUE(safe_state());
  Pass(1000ms);
  EXPECT_EQ(machine->glass().crack_count(), cracks) << "nothing fires any more";
}

// Its time waits for a host that is silent; one that has gone closes the shutters.
TEST_F(MachineSafety, InLockstepOnlyALineThatEndsIsLost) {
  StartFiring(true);
  ASSERT_EQ(machine->laser().shutters(), 1);
  SendOnLaser();
  laser_in->cut = true;
  Pass(10s);
  EXPECT_FALSE(safe_state());
  EXPECT_EQ(machine->laser().shutters(), 1);
  machine->PlugLaserLine(nullptr);
  Pass(1ms);
  EXPECT_TRUE(safe_state());
  EXPECT_EQ(machine->laser().shutters(), 0);
}

TEST_F(MachineSafety, BytesThatAreNoFramesOfThisSessionAreSilence) {
  StartFiring(false);
  SendOnLaser();
  laser_in->cut = true;
  std::vector<std::byte> stale, broken;
  link::AppendFrame({0x03, laser_host->session() + 1, 0, 1, 256}, {}, stale);
  link::AppendFrame({0x03, laser_host->session(), 0, 1, 256}, {}, broken);
  broken.back() ^= std::byte{1};
  for (int i = 0; i < 251; ++i) {
    EXPECT_FALSE(safe_state());
    for (const auto& bytes : {stale, broken})
      laser_in->bytes.insert(laser_in->bytes.end(), bytes.begin(), bytes.end());
    Pass(1ms);
  }
  EXPECT_TRUE(safe_state());
}

TEST_F(MachineSafety, KeepAlivesAloneKeepItGoing) {
  StartFiring(false);
  Pass(2000ms);
  EXPECT_FALSE(safe_state());
  EXPECT_EQ(machine->laser().shutters(), 1);
}

TEST_F(MachineSafety, AHostThatComesBackFindsTheSafeStateUntilItsReset) {
  StartFiring(false);
  laser_in->cut = true;
  Pass(400ms);
  ASSERT_TRUE(safe_state());
  laser_in->cut = false;
  Pass(200ms);
  ASSERT_TRUE(laser_host->up());
  const std::uint64_t cracks = machine->glass().crack_count();
  SendLaser(LaserFrame::kShutterCommand, Encode(link::ShutterCommand{1}));
  SendLaser(
      LaserFrame::kArmWindow,
      Encode(link::ArmWindow{machine->laser().tick() + 3, false, {true, true, true}}));
  Pass(100ms);
  EXPECT_EQ(machine->laser().shutters(), 0);
  EXPECT_EQ(machine->glass().crack_count(), cracks);
  ASSERT_FALSE(received.laser_statuses.empty());
  EXPECT_NE(received.laser_statuses.back().interlocks & link::kSafeState, 0);

  SendLaser(LaserFrame::kLaserReset);
  SendLaser(LaserFrame::kShutterCommand, Encode(link::ShutterCommand{1}));
  SendLaser(
      LaserFrame::kArmWindow,
      Encode(link::ArmWindow{machine->laser().tick() + 3, false, {true, true, true}}));
  Pass(100ms);
  EXPECT_EQ(machine->glass().crack_count(), cracks + 3);
}

TEST_F(MachineSafety, ANewHostWithinTheQuarterSecondFindsNothingArmed) {
  StartFiring(false);
  PlugLaser();  // at once: the machine never was without a line for long
  Pass(50ms);
  ASSERT_TRUE(laser_host->up());
  const std::uint64_t cracks = machine->glass().crack_count();
  Pass(500ms);
  EXPECT_EQ(machine->glass().crack_count(), cracks);
  EXPECT_EQ(received.laser_identities.size(), 2u);
}

TEST_F(MachineSafety, AnUnpluggedLaserLineIsTheSafeState) {
  StartFiring(false);
  machine->PlugLaserLine(nullptr);
  laser_host.reset();
  Pass(1ms);
  EXPECT_TRUE(safe_state());
  EXPECT_EQ(machine->laser().shutters(), 0);
}

TEST_F(MachineSafety, SilenceOnTheMotionLineStopsTheStage) {
  StartMoving();
  SendOnMotion();
  motion_in->cut = true;
  Pass(240ms);
  EXPECT_EQ(machine->stage().Report().fault, StageFault::kNone);
  Pass(11ms);
  EXPECT_EQ(machine->stage().Report().fault, StageFault::kSafeState);
  const double at_mm = machine->stage().actual_mm().x();
  Pass(30ms);
  EXPECT_FALSE(machine->stage().running());
  // v^2 / 2a at no more than 50 mm/s, and a tick's way.
  EXPECT_LT(machine->stage().actual_mm().x() - at_mm, 2500.0 / 14000 + 0.5);
  const Vec3 rest_mm = machine->stage().actual_mm();
  Pass(500ms);
  EXPECT_EQ(machine->stage().actual_mm(), rest_mm);
}

TEST_F(MachineSafety, SilenceAtRestIsNoFault) {
  StartMoving();
  Pass(1500ms);
  ASSERT_FALSE(machine->stage().running());
  motion_in->cut = true;
  Pass(1000ms);
  EXPECT_EQ(machine->stage().Report().fault, StageFault::kNone);
}

TEST_F(MachineSafety, AnUnpluggedMotionLineStopsTheStage) {
  StartMoving();
  machine->PlugMotionLine(nullptr);
  motion_host.reset();
  Pass(30ms);
  EXPECT_FALSE(machine->stage().running());
  EXPECT_EQ(machine->stage().Report().fault, StageFault::kSafeState);
}

TEST_F(MachineSafety, FaultsAndInterlocksAreReportedAtOnce) {
  StartMoving();
  SendOnMotion();
  const auto reported_fault = [this] {
    return !received.motion_statuses.empty() &&
           received.motion_statuses.back().fault == StageFault::kLimit;
  };
  machine->stage().Fail(StageFault::kLimit);
  Pass(2ms);
  EXPECT_TRUE(reported_fault());
  machine->laser().SetDoor(false);
  Pass(2ms);
  EXPECT_EQ(received.laser_statuses.back().interlocks & link::kDoorClosed, 0);
}

// The newest host has the machine, whatever line it comes by.
TEST_F(MachineSafety, AnOlderHostThatComesBackFiresNothing) {
  Start(PlainOptions(false));
  const auto older = laser_epoch;
  Connect();
  laser_epoch = std::make_shared<link::LineEpoch>();
  PlugLaser();
  Connect();
  EXPECT_GT(laser_epoch->number, older->number);
  EXPECT_FALSE(older->fenced) << "it has not heard of it";
  laser_epoch = older;
  PlugLaser();
  Pass(500ms);
  EXPECT_TRUE(older->fenced);
  EXPECT_FALSE(laser_host->up());
  EXPECT_FALSE(laser_host->CanSend());
}

TEST_F(MachineSafety, AStageInTroubleDoesNotFireWhereItShouldNotBe) {
  // Gated pulses on a stage that is stuck: in position never comes on.
  Start(PlainOptions(false));
  Connect();
  OpenShutterAndLamp();
  machine->stage().Stick(0);
  const std::uint64_t start = machine->laser().tick() + 5;
  SendMotion(MotionFrame::kBeginRun, Encode(link::BeginRun{1, start}));
  SendMotion(MotionFrame::kSegments,
             Encode(Frame({{{50, 0, 0}, {0, 0, 0}, kTick, true},
                           {{500, 0, 0}, {0, 0, 0}, 9 * kTick, true},
                           {{0, 0, 0}, {0, 0, 0}, 9 * kTick, false, true}})));
  SendLaser(LaserFrame::kArmWindow,
            Encode(link::ArmWindow{start, true, std::vector<bool>(20, true)}));
  Pass(400ms);
  EXPECT_FALSE(machine->stage().running());
  EXPECT_EQ(machine->glass().crack_count(), 0u);
}

}  // namespace
}  // namespace intaglio::virtual_engraver
