// Outputs and inputs of the laser's controller for other uses: what is on goes off with
// every stop, and an input that is not as it was commanded lets nothing fire.

#include <gmock/gmock.h>

#include "services/virtual_engraver/commands.h"
#include "tests/services/virtual_engraver/machine_bench.h"

namespace intaglio::virtual_engraver {
namespace {

using link::AccessoryCommand;
using link::AccessoryState;
using link::TickOutcome;
using ::testing::HasSubstr;
using namespace std::chrono_literals;

LaserOptions WithSpares() {
  LaserOptions options;
  options.warm_up_s = 0;
  options.min_energy_mj = 0;  // windows without an energy fire
  options.output_count = 3;
  options.inputs = {true, false};
  return options;
}

std::uint8_t On(const Laser& laser) { return laser.accessories().on; }

/// A pulse at the next tick, of an open shutter.
bool Fires(Laser& laser) {
  laser.SetLamp({true, 100});
  laser.SetShutters(1);
  laser.AdvanceTick(false);
  laser.Decide({laser.tick() + 1, false, {true}});
  return laser.AdvanceTick(false) != 0;
}

TEST(Accessories, OfALaserWithoutThemAreNone) {
  Laser laser({});
  laser.Command({0xff, 0, 0});
  EXPECT_EQ(laser.accessories(), AccessoryState());
}

TEST(Accessories, AreSwitchedAsCommandedAsFarAsTheyAreThere) {
  Laser laser(WithSpares());
  EXPECT_EQ(laser.accessories(), (AccessoryState{3, 2, 0, 1}));
  laser.Command({0b1010, 0, 0});
  EXPECT_EQ(On(laser), 0b010);
  laser.Command({0b0101, 0, 0});
  EXPECT_EQ(On(laser), 0b101);
  laser.Command({});
  EXPECT_EQ(On(laser), 0);
}

// Whatever ends a permission to fire ends them, and they do not come back by themselves.
TEST(Accessories, GoOffWithEveryStopAndStayOff) {
  const std::pair<void (*)(Laser&), void (*)(Laser&)> stops[] = {
      {[](Laser& one) { one.SetKey(false); }, [](Laser& one) { one.SetKey(true); }},
      {[](Laser& one) { one.SetDoor(false); }, [](Laser& one) { one.SetDoor(true); }},
      {[](Laser& one) { one.SetStopButton(true); },
       [](Laser& one) {
         one.SetStopButton(false);
         one.Reset();
       }},
      {[](Laser& one) { one.Stop(); }, [](Laser& one) { one.Reset(); }},
      {[](Laser& one) { one.EnterSafeState(); }, [](Laser& one) { one.Reset(); }},
      {[](Laser& one) { one.SetInput(0, false); },
       [](Laser& one) { one.SetInput(0, true); }}};
  for (const auto& [stop, close] : stops) {
    Laser laser(WithSpares());
    const AccessoryCommand command{0b11, 0b01, 0b01};
    laser.Command(command);
    ASSERT_EQ(On(laser), 0b11);
    stop(laser);
    EXPECT_EQ(On(laser), 0);
    laser.Command(command);
    EXPECT_EQ(On(laser), 0) << "it is still open";
    close(laser);
    EXPECT_EQ(On(laser), 0) << "nobody has commanded it";
    laser.Command(command);
    EXPECT_EQ(On(laser), 0b11);
  }
}

TEST(Accessories, AnotherSessionSwitchesThemOff) {
  Laser laser(WithSpares());
  laser.Command({0b11, 0, 0});
  EXPECT_TRUE(laser.is_live()) << "a silent host would leave them on";
  laser.NewSession();
  EXPECT_EQ(On(laser), 0);
  EXPECT_FALSE(laser.is_live());
}

TEST(Accessories, AWatchedInputIsAnInterlock) {
  Laser laser(WithSpares());
  EXPECT_TRUE(Fires(laser)) << "it is not watched";
  laser.Command({0, 0b11, 0b01});  // 1 on, 2 off
  EXPECT_TRUE(Fires(laser));
  EXPECT_EQ(laser.Report().openings, 0u);
  laser.SetInput(1, true);
  EXPECT_EQ(laser.Report().openings, 1u);
  (void)laser.TakeReports();
  EXPECT_FALSE(Fires(laser));
  EXPECT_EQ(laser.TakeReports().front().outcome.front(), TickOutcome::kInterlocked);
  laser.SetInput(1, false);
  EXPECT_TRUE(Fires(laser));
  laser.NewSession();
  laser.SetInput(0, false);
  EXPECT_EQ(laser.Report().openings, 2u) << "while no host listens";
}

// One that it does not have is off, and not as it has to be.
TEST(Accessories, AnInputThatIsNotThereLetsNothingFire) {
  Laser laser(WithSpares());
  laser.Command({0, 0b1000'0000, 0b1000'0000});
  EXPECT_FALSE(Fires(laser));
}

class MachineWithSpares : public MachineBench {
 protected:
  void SetUp() override {
    MachineOptions options = PlainOptions(false);
    options.laser.output_count = 3;
    options.laser.inputs = {true, false};
    Start(options);
    commands = std::make_unique<Commands>(*machine, plugs);
    Connect();
  }
  void SwitchOn() {
    SendLaser(link::LaserFrame::kAccessoryCommand,
              Encode(AccessoryCommand{0b101, 0b01, 0b01}));
    Pass(1ms);
    ASSERT_EQ(On(machine->laser()), 0b101);
  }
  Plugs plugs;
  std::unique_ptr<Commands> commands;
};

// The watchdog of the line, with no shutter open and nothing armed.
TEST_F(MachineWithSpares, AQuarterOfASecondOfSilenceSwitchesThemOff) {
  SwitchOn();
  laser_in->cut = true;
  Pass(249ms);
  EXPECT_EQ(On(machine->laser()), 0b101);
  Pass(2ms);
  EXPECT_EQ(On(machine->laser()), 0);
  EXPECT_NE(machine->laser().Report().interlocks & link::kSafeState, 0);
}

TEST_F(MachineWithSpares, AHostThatIsGoneSwitchesThemOffAtOnce) {
  SwitchOn();
  machine->PlugLaserLine(nullptr);
  Pass(1ms);
  EXPECT_EQ(On(machine->laser()), 0);
}

TEST_F(MachineWithSpares, ShowsThemAndHasAPersonAtItsInputs) {
  SwitchOn();
  EXPECT_THAT(commands->Do("status"), HasSubstr("\"outputs\": 5, \"inputs\": 1}"));
  EXPECT_EQ(commands->Do("input 2 on"), "ok");
  EXPECT_THAT(commands->Do("status"), HasSubstr("\"outputs\": 5, \"inputs\": 3}"));
  EXPECT_EQ(commands->Do("input 1 off"), "ok");
  EXPECT_THAT(commands->Do("status"), HasSubstr("\"outputs\": 0, \"inputs\": 2}"));
  EXPECT_EQ(commands->Do("input 3 on"),
            "error input 1..2 on|off: the machine has 2 inputs");
  EXPECT_THAT(commands->Do("input 1"), HasSubstr("error unknown command"));
}

}  // namespace
}  // namespace intaglio::virtual_engraver
