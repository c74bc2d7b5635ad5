// The lock of the door, and the compressed air of a stage that floats on it.

#include <gmock/gmock.h>

#include "services/virtual_engraver/commands.h"
#include "tests/services/virtual_engraver/machine_bench.h"
#include "tests/services/virtual_engraver/stage_path.h"

namespace intaglio::virtual_engraver {
namespace {

using link::TickOutcome;
using ::testing::HasSubstr;

LaserOptions Locking() {
  LaserOptions options;
  options.warm_up_s = 0;
  options.channels = 4;
  options.min_energy_mj = 0;  // windows without an energy fire
  options.locks_door = true;
  return options;
}

bool IsLocked(const Laser& laser) {
  return (laser.Report().interlocks & link::kDoorLocked) != 0;
}

TEST(DoorLock, HoldsWhileAShutterIsOpenOrMoves) {
  Laser laser(Locking());
  EXPECT_TRUE(laser.Identity().locks_door);
  laser.SetTiming({.shutter_time_ms = 25});
  laser.SetLamp({true, 100});
  laser.AdvanceTick(false);
  EXPECT_FALSE(IsLocked(laser));
  laser.SetShutters(0b0010);
  EXPECT_EQ(laser.Report().shutters_open, 0) << "it still moves";
  EXPECT_TRUE(IsLocked(laser)) << "before the shutter is open";
  for (int i = 0; i < 10; ++i) laser.AdvanceTick(false);
  EXPECT_TRUE(IsLocked(laser));
  laser.SetShutters(0);
  for (int i = 0; i < 2; ++i) {
    laser.AdvanceTick(false);
    EXPECT_TRUE(IsLocked(laser)) << "it still closes";
  }
  for (int i = 0; i < 3; ++i) laser.AdvanceTick(false);
  EXPECT_FALSE(IsLocked(laser));
}

TEST(DoorLock, NoPulseWithoutIt) {
  for (const bool broken : {false, true}) {
    Laser laser(Locking());
    laser.SetLamp({true, 100});
    laser.AdvanceTick(false);
    laser.SetShutters(1);
    laser.BreakLock(broken);
    laser.Decide({2, false, {true}});
    EXPECT_EQ(laser.AdvanceTick(false), broken ? 0 : 1);
    const auto reports = laser.TakeReports();
    ASSERT_EQ(reports.size(), 1u);
    EXPECT_EQ(reports[0].outcome[0],
              broken ? TickOutcome::kInterlocked : TickOutcome::kFiredSeen);
  }
}

TEST(DoorLock, IsNotReportedByALaserWithoutOne) {
  LaserOptions options = Locking();
  options.locks_door = false;
  Laser laser(options);
  EXPECT_FALSE(laser.Identity().locks_door);
  laser.SetShutters(1);
  EXPECT_FALSE(IsLocked(laser));
}

// The door switch is the truth: a forced door stops the laser, and counts as opened.
TEST(DoorLock, AForcedDoorIsOpen) {
  Laser laser(Locking());
  laser.SetLamp({true, 100});
  laser.SetShutters(1);
  ASSERT_TRUE(IsLocked(laser));
  laser.SetDoor(false);
  EXPECT_FALSE(IsLocked(laser));
  EXPECT_EQ(laser.Report().openings, 1u);
  laser.Decide({1, false, {true}});
  EXPECT_EQ(laser.AdvanceTick(false), 0);
}

TEST(DoorLock, ASafeStateReleasesIt) {
  Laser laser(Locking());
  laser.SetShutters(1);
  laser.EnterSafeState();
  EXPECT_FALSE(IsLocked(laser)) << "all shutters are closed";
}

class LockedMachine : public MachineBench {
 protected:
  void SetUp() override {
    MachineOptions options = PlainOptions(false);
    options.laser.locks_door = true;
    options.stage.floats_on_air = true;
    Start(options);
    commands = std::make_unique<Commands>(*machine, plugs);
  }
  bool IsClosed() const {
    return (machine->laser().Report().interlocks & link::kDoorClosed) != 0;
  }
  Plugs plugs;
  std::unique_ptr<Commands> commands;
};

TEST_F(LockedMachine, APersonCannotOpenALockedDoor) {
  machine->laser().SetShutters(1);
  EXPECT_THAT(commands->Do("door open"), HasSubstr("error the door is locked"));
  EXPECT_TRUE(IsClosed());
  EXPECT_EQ(commands->Do("door force"), "ok");
  EXPECT_FALSE(IsClosed());
  EXPECT_EQ(commands->Do("door close"), "ok");
  EXPECT_EQ(commands->Do("lock break"), "ok");
  EXPECT_EQ(commands->Do("door open"), "ok");
  EXPECT_EQ(commands->Do("door close"), "ok");
  EXPECT_EQ(commands->Do("lock mend"), "ok");
  machine->laser().SetShutters(0);
  EXPECT_EQ(commands->Do("door open"), "ok");
  EXPECT_THAT(commands->Do("door ajar"), HasSubstr("error unknown command"));
  EXPECT_THAT(commands->Do("lock"), HasSubstr("error unknown command"));
}

TEST_F(LockedMachine, WithoutAirTheStageStopsAndTakesNoRun) {
  Stage& stage = machine->stage();
  EXPECT_TRUE(stage.Identity().watches_air);
  stage.BeginRun({1, kStartTick});
  stage.Append(Frame({{{9000, 0, 0}, {0, 0, 0}, 100 * kTick, false, true}}));
  Pass(std::chrono::milliseconds(300));
  ASSERT_TRUE(stage.running());
  EXPECT_EQ(commands->Do("air off"), "ok");
  Pass(std::chrono::milliseconds(50));
  EXPECT_FALSE(stage.running());
  EXPECT_EQ(stage.Report().fault, link::StageFault::kNoAir);
  const Vec3 at_mm = stage.actual_mm();
  stage.Reset();
  EXPECT_EQ(stage.Report().fault, link::StageFault::kNoAir);
  stage.BeginRun({2, machine->laser().tick() + 5});
  EXPECT_FALSE(stage.running());
  stage.Jog({5000000, 0, 0, 10000000});
  stage.Home();
  Pass(std::chrono::milliseconds(100));
  EXPECT_EQ(stage.actual_mm(), at_mm);
  EXPECT_EQ(commands->Do("air on"), "ok");
  EXPECT_EQ(stage.Report().fault, link::StageFault::kAirReturned);
  stage.Reset();
  EXPECT_EQ(stage.Report().fault, link::StageFault::kNone);
  stage.Jog({5000000, 0, 0, 10000000});
  EXPECT_TRUE(stage.jogging());
}

TEST(CompressedAir, IsNothingToAStageOnBearings) {
  Stage stage(Roomy(0));
  EXPECT_FALSE(stage.Identity().watches_air);
  stage.SetAir(false);
  EXPECT_EQ(stage.Report().fault, link::StageFault::kNone);
}

}  // namespace
}  // namespace intaglio::virtual_engraver
