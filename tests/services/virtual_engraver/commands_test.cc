#include "services/virtual_engraver/commands.h"

#include "services/platform/link/serial_port.h"
#include "tests/services/virtual_engraver/machine_bench.h"
#include "tests/services/virtual_engraver/stage_path.h"

namespace intaglio::virtual_engraver {
namespace {
namespace fs = std::filesystem;

class PanelCommands : public MachineBench {
 protected:
  void SetUp() override {
    Start(PlainOptions(false));
    plugs.laser.device = record_file.parent_path() / "laser";
    plugs.motion.device = record_file.parent_path() / "motion";
    commands = std::make_unique<Commands>(*machine, plugs);
    ASSERT_TRUE(commands->PlugLaser().has_value());
    ASSERT_TRUE(commands->PlugMotion().has_value());
  }
  std::uint8_t interlocks() const { return machine->laser().Report().interlocks; }
  bool Refuses(const std::string& command) {
    return commands->Do(command).rfind("error ", 0) == 0;
  }
  Plugs plugs;
  std::unique_ptr<Commands> commands;
};

TEST_F(PanelCommands, ButtonsChangeTheirInterlock) {
  struct Case {
    const char* off;
    const char* on;
    std::uint8_t bit;
  };
  for (const Case& c : {Case{"key off", "key on", link::kKeyOn},
                        Case{"door open", "door close", link::kDoorClosed}}) {
    EXPECT_EQ(commands->Do(c.off), "ok");
    EXPECT_EQ(interlocks() & c.bit, 0) << c.off;
    EXPECT_EQ(commands->Do(c.on), "ok");
    EXPECT_EQ(interlocks() & c.bit, c.bit) << c.on;
  }
}

TEST_F(PanelCommands, TheStopButtonStopsLaserAndStage) {
  machine->stage().BeginRun({1, kStartTick});
  machine->stage().Append(Frame({{{9000, 0, 0}, {0, 0, 0}, 100 * kTick, false, true}}));
  Pass(std::chrono::milliseconds(300));
  ASSERT_TRUE(machine->stage().running());
  machine->laser().SetShutters(1);
  EXPECT_EQ(commands->Do("estop press"), "ok");
  EXPECT_EQ(machine->laser().shutters(), 0);
  Pass(std::chrono::milliseconds(50));
  EXPECT_FALSE(machine->stage().running());
  EXPECT_EQ(commands->Do("estop release"), "ok");
  EXPECT_EQ(interlocks() & link::kStopReleased, 0) << "latched until the host's reset";
  machine->laser().Reset();
  EXPECT_NE(interlocks() & link::kStopReleased, 0);
}

TEST_F(PanelCommands, AColdLampWarmsUpAgain) {
  MachineOptions options = PlainOptions(false);
  options.laser.warm_up_s = 0.1;
  Start(options);
  Plugs cold_plugs;
  Commands cold(*machine, cold_plugs);
  machine->laser().SetLamp({true, 100});
  Pass(std::chrono::milliseconds(150));
  ASSERT_NE(interlocks() & link::kLampWarm, 0);
  EXPECT_EQ(cold.Do("lamp cold"), "ok");
  EXPECT_EQ(interlocks() & link::kLampWarm, 0);
  EXPECT_NE(interlocks() & link::kLampOn, 0);
  Pass(std::chrono::milliseconds(150));
  EXPECT_NE(interlocks() & link::kLampWarm, 0);
}

TEST_F(PanelCommands, TheStagesFaultsAreThoseOfTheProtocol) {
  struct Case {
    const char* command;
    link::StageFault fault;
  };
  for (const Case& c : {Case{"limit", link::StageFault::kLimit},
                        Case{"buffer starved", link::StageFault::kStarved},
                        Case{"buffer full", link::StageFault::kBadSequence}}) {
    EXPECT_EQ(commands->Do(c.command), "ok");
    EXPECT_EQ(machine->stage().fault(), c.fault) << c.command;
    machine->stage().Reset();
    EXPECT_EQ(machine->stage().fault(), link::StageFault::kNone);
  }
}

TEST_F(PanelCommands, StatusIsOneLineOfEverything) {
  const std::string status = commands->Do("status");
  EXPECT_EQ(status.rfind("ok {", 0), 0u);
  for (const char* name : {"tick", "rate_hz", "interlocks", "shutters", "pulses",
                           "cracks", "stage_mm", "running", "safe_state"}) {
    EXPECT_NE(status.find('"' + std::string(name) + "\": "), std::string::npos) << name;
  }
  EXPECT_EQ(status.find('\n'), std::string::npos);
}

TEST_F(PanelCommands, RefusesWhatItDoesNotKnow) {
  for (const char* command : {"",
                              "   ",
                              "open",
                              "key",
                              "key maybe",
                              "key on on",
                              "door",
                              "estop",
                              "stick",
                              "stick w",
                              "miss",
                              "miss -1",
                              "miss 1.5",
                              "miss many",
                              "blind",
                              "blind -1",
                              "lamp",
                              "lamp hot",
                              "lamp-sync",
                              "lamp-sync miss",
                              "lamp-sync miss -1",
                              "lamp-sync late nan",
                              "lamp-sync late 60001",
                              "limit x",
                              "buffer",
                              "buffer empty",
                              "drop-bytes",
                              "drop-bytes 0.1",
                              "drop-bytes 2 laser",
                              "drop-bytes -0.1 laser",
                              "drop-bytes nan laser",
                              "drop-bytes 0.1 line",
                              "plug",
                              "plug panel",
                              "unplug all"}) {
    EXPECT_TRUE(Refuses(command)) << command;
  }
  EXPECT_FALSE(commands->quit());
  EXPECT_EQ(commands->Do("quit"), "ok");
  EXPECT_TRUE(commands->quit());
}

TEST_F(PanelCommands, PlugsAreTheSymbolicLinks) {
  for (const auto& [name, path] : {std::pair{"laser", plugs.laser.device},
                                   std::pair{"motion", plugs.motion.device}}) {
    EXPECT_TRUE(link::OpenSerialPort(path, 115200).has_value()) << name;
    EXPECT_EQ(commands->Do(std::string("unplug ") + name), "ok");
    EXPECT_FALSE(fs::exists(path)) << name;
    const auto gone = link::OpenSerialPort(path, 115200);
    ASSERT_FALSE(gone.has_value());
    EXPECT_EQ(gone.error().code, ErrorCode::kIo);
    EXPECT_TRUE(Refuses(std::string("drop-bytes 0.5 ") + name)) << "nothing is plugged";
    EXPECT_EQ(commands->Do(std::string("plug ") + name), "ok");
    EXPECT_TRUE(link::OpenSerialPort(path, 115200).has_value()) << name;
    EXPECT_EQ(commands->Do(std::string("drop-bytes 0.5 ") + name), "ok");
  }
}

TEST_F(PanelCommands, APlugOverTcpKeepsItsPort) {
  Plugs tcp{{"tcp:127.0.0.1:0"}, {"tcp:127.0.0.1:0"}, 0};
  Commands over_tcp(*machine, tcp);
  ASSERT_TRUE(over_tcp.PlugLaser());
  ASSERT_TRUE(over_tcp.PlugMotion());
  const std::string device = tcp.laser.device;
  EXPECT_NE(device, "tcp:127.0.0.1:0");
  EXPECT_NE(device, tcp.motion.device);
  EXPECT_EQ(over_tcp.Do("unplug laser"), "ok");
  EXPECT_EQ(over_tcp.Do("plug laser"), "ok");
  EXPECT_EQ(tcp.laser.device, device);
  EXPECT_EQ(over_tcp.Do("plug laser"), "ok") << "again, while it is plugged in";
  EXPECT_EQ(tcp.laser.device, device);
}

TEST(ScheduledFault, IsATickAndACommand) {
  const auto fault = ParseFault("2000 door open");
  ASSERT_TRUE(fault.has_value());
  EXPECT_EQ(fault->tick, 2000u);
  EXPECT_EQ(fault->command, "door open");
  for (const char* text : {"", "2000", "door open", "-1 door open", "1.5 door open"}) {
    const auto wrong = ParseFault(text);
    ASSERT_FALSE(wrong.has_value()) << text;
    EXPECT_EQ(wrong.error().code, ErrorCode::kInvalidValue);
  }
}

}  // namespace
}  // namespace intaglio::virtual_engraver
