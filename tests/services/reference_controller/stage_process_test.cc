// The program in real time with a stage: a host at its motion line, and the record of its
// outputs.

#include <gtest/gtest.h>
#include <signal.h>
#include <time.h>

#include <array>
#include <chrono>
#include <fstream>
#include <memory>
#include <sstream>

#include "services/drivers/motion_drivers.h"
#include "services/reference_controller/exact_time.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio::reference_controller {
namespace {

using namespace std::chrono_literals;

constexpr const char* kLaserBoard = R"(
  warm_up_s: 0 trigger_max_delay_us: 10000
  q_switch { line: 4 } shutters { line: 5 } lamp { line: 7 }
  lamp_trigger { line: 8 } alive { line: 9 } key { line: 10 } door { line: 11 }
  stop { line: 12 } in_position { line: 13 }
)";
// Steps are never too late for this stage, however busy the computer is.
constexpr const char* kStageBoard = R"(
  x { step { line: 20 } direction { line: 21 } free { line: 22 } steps_per_mm: 100
      max_speed_mm_s: 50 travel_max_mm: 100 switch_mm: -1 }
  y { step { line: 23 } direction { line: 24 } free { line: 25 } steps_per_mm: 100
      max_speed_mm_s: 50 travel_max_mm: 100 switch_mm: -1 }
  z { step { line: 26 } direction { line: 27 } free { line: 28 } steps_per_mm: 100
      max_speed_mm_s: 50 travel_max_mm: 100 switch_mm: -1 }
  following_error_limit_mm: 10 home_speed_mm_s: 20
  enable { line: 29 } in_position_output { line: 30 } alive { line: 31 }
  stop { line: 32 }
)";

class StageProgram : public ::testing::Test {
 protected:
  StageProgram() {
    std::ofstream(folder / "board.textproto") << kLaserBoard;
    std::ofstream(folder / "stage.textproto") << kStageBoard;
    program = std::make_unique<testing::Running>(
        testing::Program("intaglio-reference-controller"),
        std::vector<std::string>{"--board", folder / "board.textproto", "--line",
                                 folder / "laser", "--stage-board",
                                 folder / "stage.textproto", "--stage-line",
                                 folder / "motion", "--simulate", folder / "edges.csv"},
        folder / "controller.log");
  }

  bool Until(const std::function<bool()>& condition) {
    return testing::Eventually(
        [&] {
          if (host) host->Poll();
          return condition();
        },
        20s);
  }
  bool IsAtRest() const {
    return host->state().link_up && host->state().at_rest &&
           host->state().fault == intaglio_MOTION_OK;
  }
  void Connect(MachineSpec machine) {
    ASSERT_TRUE(Until([&] {
      return program->Output().find("ready ") != std::string::npos;
    })) << program->Output();
    machine.set_name("els-03");
    machine.mutable_motion_line()->set_protocol("virtual-stage");
    machine.mutable_motion_line()->set_device(folder / "motion");
    machine.mutable_motion_line()->set_baud(115200);
    host = drivers::MakeMotionDriver(machine).value();
  }
  void ConnectAndHome() {
    ASSERT_NO_FATAL_FAILURE(Connect({}));
    ASSERT_TRUE(Until([&] { return IsAtRest(); })) << host->state().message;
    EXPECT_FALSE(host->state().homed);
    // A host that a busy computer kept waiting for 250 ms has lost its motion.
    ASSERT_TRUE(Until([&] {
      if (host->state().link_up && host->state().at_rest) {
        if (host->state().homed) return true;
        (void)host->ClearFault();
        (void)host->Home();
      }
      return false;
    })) << host->state().message;
  }
  struct Record {
    std::array<std::int64_t, 3> steps = {};
    std::size_t edges = 0;
    bool enabled = false, step_on = false;
  };
  /// What the recorded edges make of the axes.
  Record Edges() const {
    Record record;
    std::array<bool, 3> plus = {};
    std::istringstream lines(testing::TextIn(folder / "edges.csv"));
    for (std::string line; std::getline(lines, line);) {
      const auto first = line.find(','), second = line.rfind(',');
      if (first == second || line.back() > '1') continue;
      const std::string output = line.substr(first + 1, second - first - 1);
      const bool on = line.back() == '1';
      if (output == "enable") record.enabled = on, ++record.edges;
      if (output.size() < 3 || output[1] != '.') continue;
      ++record.edges;
      const auto axis = static_cast<std::size_t>(output[0] - 'x');
      if (output.ends_with("direction")) plus.at(axis) = on;
      if (!output.ends_with("step")) continue;
      record.step_on = on;
      if (on) record.steps.at(axis) += plus.at(axis) ? 1 : -1;
    }
    return record;
  }

  std::filesystem::path folder = test::FreshFolder();
  std::unique_ptr<testing::Running> program;
  std::unique_ptr<drivers::MotionDriver> host;
};

TEST_F(StageProgram, HomesAndStepsToItsPlaceAndBrakesWhenItIsEnded) {
  ConnectAndHome();
  const Record home = Edges();
  EXPECT_TRUE(home.enabled);
  ASSERT_TRUE(Until([&] {
    if (!IsAtRest()) {
      if (host->state().at_rest) (void)host->ClearFault();
      return false;
    }
    if ((host->state().position_mm - Vec3(3, 2, 1)).norm() < 0.02) return true;
    (void)host->Jog(Vec3(3, 2, 1), 20);
    return false;
  })) << host->state().message;
  const Record at = Edges();
  for (const std::size_t axis : {0U, 1U, 2U})
    EXPECT_NEAR(static_cast<double>(at.steps[axis] - home.steps[axis]),
                100.0 * (3 - static_cast<double>(axis)), 1.1);
  ASSERT_TRUE(host->Jog(Vec3(90, 2, 1), 10).has_value());
  ASSERT_TRUE(Until([&] { return host->state().position_mm.x() > 5; }));
  program->Signal(SIGTERM);
  const auto end = program->WaitForEnd(10s);
  EXPECT_EQ(end.exit_code, 0) << end.output;
  EXPECT_FALSE(Edges().enabled);
  EXPECT_FALSE(Edges().step_on);
  EXPECT_LT(Edges().steps[0] - home.steps[0], 8900);
}

TEST_F(StageProgram, IsRefusedByAProfileWithAFasterAxisBeforeAnythingMoves) {
  MachineSpec machine;
  machine.mutable_x()->set_max_speed_mm_s(50);
  machine.mutable_z()->set_max_speed_mm_s(50.5);
  ASSERT_NO_FATAL_FAILURE(Connect(machine));
  ASSERT_TRUE(Until([&] {
    return host->state().fault == intaglio_MOTION_WRONG_CONTROLLER;
  })) << host->state().message;
  EXPECT_EQ(host->state().message,
            "z.max_speed_mm_s: 50.5 mm/s is faster than the stage controller can step "
            "this axis; reduce it to at most 50 mm/s in the machine profile");
  EXPECT_FALSE(host->Home().has_value());
  EXPECT_EQ(Edges().edges, 0U);
}

TEST_F(StageProgram, KilledItStepsNoMore) {
  ConnectAndHome();
  const Record home = Edges();
  ASSERT_TRUE(host->Jog(Vec3(90, 0, 0), 10).has_value());
  ASSERT_TRUE(Until([&] { return Edges().steps[0] > home.steps[0] + 100; }));
  program->Signal(SIGKILL);
  (void)program->WaitForEnd(10s);
  const std::size_t edges = Edges().edges;
  EXPECT_TRUE(Until([&] { return !host->state().link_up; }));
  EXPECT_EQ(Edges().edges, edges);
}

// The command of docs/machines/els-03.md, with two seconds in place of thirty.
TEST(StageMeasurement, PrintsTheTableOfItsSteps) {
  const std::string documented =
      "intaglio-reference-controller --board deploy/boards/els-03.textproto "
      "--stage-board deploy/boards/els-03-stage.textproto --measure 30\n";
  EXPECT_NE(
      testing::TextIn(INTAGLIO_SOURCE_DIR "/docs/machines/els-03.md").find(documented),
      std::string::npos);
  testing::Running run(
      testing::Program("intaglio-reference-controller"),
      {"--board", INTAGLIO_SOURCE_DIR "/deploy/boards/els-03.textproto", "--stage-board",
       INTAGLIO_SOURCE_DIR "/deploy/boards/els-03-stage.textproto", "--measure", "2"},
      test::FreshFolder() / "measured.txt");
  const auto end = run.WaitForEnd(30s);
  EXPECT_EQ(end.exit_code, 0) << end.output;
  for (const char* row : {"step period", "62.50 us are commanded, 80 mm/s"})
    EXPECT_NE(end.output.find(row), std::string::npos) << end.output;
}

// The kernel holds a real-time thread that takes more than 95 % for 50 ms.
TEST(StageTurns, LeaveTheProcessorAloneForAPartOfEachMillisecond) {
  const auto seconds_of = [](clockid_t clock) {
    timespec time{};
    clock_gettime(clock, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  TurnWait turns(ExactTime());
  const double busy = seconds_of(CLOCK_THREAD_CPUTIME_ID);
  const double began = seconds_of(CLOCK_MONOTONIC);
  while (seconds_of(CLOCK_MONOTONIC) < began + 0.2) turns.WaitFor(10us);
  EXPECT_LT(seconds_of(CLOCK_THREAD_CPUTIME_ID) - busy,
            0.95 * (seconds_of(CLOCK_MONOTONIC) - began));
}

TEST(StageArguments, AreRefusedWhereTheyDoNotFit) {
  const std::string board = INTAGLIO_SOURCE_DIR "/deploy/boards/els-03.textproto";
  const auto folder = test::FreshFolder();
  testing::Running half(testing::Program("intaglio-reference-controller"),
                        {"--board", board, "--line", folder / "laser", "--stage-board",
                         board, "--simulate", folder / "none.csv"},
                        folder / "half.log");
  const auto end = half.WaitForEnd(10s);
  EXPECT_EQ(end.exit_code, 2);
  EXPECT_NE(end.output.find("--stage-board and --stage-line together"), std::string::npos)
      << end.output;
}

}  // namespace
}  // namespace intaglio::reference_controller
