// The program in real time: a host at its pseudo-terminal, and the record of its outputs.

#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <sstream>

#include "services/drivers/laser_drivers.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio::reference_controller {
namespace {

using namespace std::chrono_literals;

// A trigger is never too late for this laser, however busy the computer is.
constexpr const char* kBoard = R"(
  warm_up_s: 0 trigger_max_delay_us: 10000
  q_switch { line: 4 } shutters { line: 5 } shutters { line: 6 } lamp { line: 7 }
  lamp_trigger { line: 8 } alive { line: 9 } key { line: 10 } door { line: 11 }
  stop { line: 12 } in_position { line: 13 } photosensors { line: 14 }
  photosensors { line: 15 }
)";

class ControllerProgram : public ::testing::Test {
 protected:
  ControllerProgram() {
    std::ofstream(folder / "board.textproto") << kBoard;
    program = std::make_unique<testing::Running>(
        testing::Program("intaglio-reference-controller"),
        std::vector<std::string>{"--board", folder / "board.textproto", "--line",
                                 folder / "laser", "--simulate", folder / "edges.csv"},
        folder / "controller.log");
  }

  bool Until(const std::function<bool()>& condition) {
    return testing::Eventually(
        [&] {
          if (host) host->Poll([](const auto&) {}, [](const auto&) {});
          return condition();
        },
        10s);
  }

  void Connect() {
    ASSERT_TRUE(Until([&] {
      return program->Output().find("ready ") != std::string::npos;
    })) << program->Output();
    MachineSpec machine;
    machine.set_name("els-03");
    machine.mutable_laser_line()->set_protocol("virtual-laser");
    machine.mutable_laser_line()->set_device(folder / "laser");
    machine.mutable_laser_line()->set_baud(115200);
    host = drivers::MakeLaserDriver(machine).value();
    ASSERT_TRUE(Until([&] { return host->up(); })) << host->message();
  }
  void OpenLampAndShutters() {
    (void)host->Reset();
    (void)host->Lamp(true, 100);
    (void)host->OpenShutters(3);
  }
  /// A host that a busy computer kept waiting for 250 ms has lost its shutters and
  /// windows: it commands them again, once a status has shown what came of it before.
  bool FiresUntil(std::uint64_t count) {
    return Until([&] {
      const link::LaserStatus& status = host->status();
      if (!host->up() || status.pulse_count >= count) return host->up();
      const auto now = std::chrono::steady_clock::now();
      if (now < next_command) return false;
      next_command = now + 300ms;
      if (host->Has(link::kSafeState) || status.shutters_open != 3) {
        OpenLampAndShutters();
      } else if (status.decided_through <= status.tick) {
        (void)host->Arm(
            {status.tick + 20, true, std::vector<bool>(200, true), false, 30});
      }
      return false;
    });
  }
  /// How often the output went on; and whether it is on at the end.
  std::pair<int, bool> EdgesOf(const std::string& output) const {
    std::istringstream lines(testing::TextIn(folder / "edges.csv"));
    std::pair<int, bool> edges;
    for (std::string line; std::getline(lines, line);) {
      if (line.find("," + output + ",") == std::string::npos) continue;
      edges.second = line.back() == '1';
      if (edges.second) ++edges.first;
    }
    return edges;
  }

  std::filesystem::path folder = test::FreshFolder();
  std::unique_ptr<testing::Running> program;
  std::unique_ptr<drivers::LaserController> host;
  std::chrono::steady_clock::time_point next_command = {};
};

TEST_F(ControllerProgram, FiresWhatIsArmedAndSwitchesOffWhenItIsEnded) {
  Connect();
  OpenLampAndShutters();
  ASSERT_TRUE(Until([&] { return EdgesOf("lamp_trigger").first > 10; }));
  EXPECT_EQ(EdgesOf("q_switch").first, 0) << "nothing is armed yet";
  ASSERT_TRUE(FiresUntil(40));
  ASSERT_TRUE(host->Disarm().has_value());
  ASSERT_TRUE(Until([&] { return host->disarmed(); }));
  EXPECT_EQ(static_cast<std::uint64_t>(EdgesOf("q_switch").first),
            host->status().pulse_count);
  EXPECT_GT(EdgesOf("shutters[1]").first, 0);
  program->Signal(SIGTERM);
  const auto end = program->WaitForEnd(10s);
  EXPECT_EQ(end.exit_code, 0) << end.output;
  for (const char* output :
       {"q_switch", "shutters[0]", "shutters[1]", "lamp", "lamp_trigger"})
    EXPECT_FALSE(EdgesOf(output).second) << output;
}

TEST_F(ControllerProgram, AHostThatDiesClosesTheShutters) {
  Connect();
  ASSERT_TRUE(FiresUntil(10));
  host.reset();
  ASSERT_TRUE(Until([&] { return !EdgesOf("shutters[0]").second; }));
  const int fired = EdgesOf("q_switch").first;
  // Ten periods of the lamp later.
  const int lamps = EdgesOf("lamp_trigger").first;
  ASSERT_TRUE(Until([&] { return EdgesOf("lamp_trigger").first > lamps + 10; }));
  EXPECT_EQ(EdgesOf("q_switch").first, fired);
}

// No process switches its outputs off when it is killed: the hardware gate does, as
// docs/machines/els-03.md says.
TEST_F(ControllerProgram, KilledItLeavesTheLampOnAndFiresNoMore) {
  Connect();
  ASSERT_TRUE(FiresUntil(10));
  program->Signal(SIGKILL);
  (void)program->WaitForEnd(10s);
  EXPECT_TRUE(EdgesOf("lamp").second);
  const int fired = EdgesOf("q_switch").first;
  EXPECT_TRUE(Until([&] { return !host->up(); }));
  EXPECT_EQ(EdgesOf("q_switch").first, fired);
}

// The command of docs/machines/els-03.md, with a second in place of thirty.
TEST(ControllerMeasurement, PrintsTheTableOfItsEdges) {
  const std::string documented =
      "intaglio-reference-controller --board deploy/boards/els-03.textproto --measure 30 "
      "--rate 200\n";
  EXPECT_NE(
      testing::TextIn(INTAGLIO_SOURCE_DIR "/docs/machines/els-03.md").find(documented),
      std::string::npos);
  testing::Running run(testing::Program("intaglio-reference-controller"),
                       {"--board", INTAGLIO_SOURCE_DIR "/deploy/boards/els-03.textproto",
                        "--measure", "1", "--rate", "200"},
                       test::FreshFolder() / "measured.txt");
  const auto end = run.WaitForEnd(30s);
  EXPECT_EQ(end.exit_code, 0) << end.output;
  for (const char* row : {"lamp period", "trigger at", "its width", "without a trigger"})
    EXPECT_NE(end.output.find(row), std::string::npos) << end.output;
}

TEST_F(ControllerProgram, AWrongBoardIsRefusedBeforeAnythingIsOpened) {
  std::ofstream(folder / "wrong.textproto") << "q_switch { line: 4 }";
  testing::Running wrong(testing::Program("intaglio-reference-controller"),
                         {"--board", folder / "wrong.textproto", "--line",
                          folder / "other", "--simulate", folder / "none.csv"},
                         folder / "wrong.log");
  const auto end = wrong.WaitForEnd(10s);
  EXPECT_EQ(end.exit_code, 1);
  EXPECT_NE(end.output.find("wrong.textproto: alive: is missing"), std::string::npos)
      << end.output;
  EXPECT_FALSE(std::filesystem::exists(folder / "none.csv"));
}

}  // namespace
}  // namespace intaglio::reference_controller
