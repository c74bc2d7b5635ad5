// The lines of a board against a libgpiod of its own, which keeps what was asked of it.

#include "services/reference_controller/gpio_pins.h"

#include <gmock/gmock.h>
#include <gpiod.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <cstring>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "services/reference_controller/board_file.h"
#include "services/reference_controller/stage_board.h"
#include "services/reference_controller/stage_controller.h"
#include "services/reference_controller/step_axes.h"

struct gpiod_line {
  unsigned number = 0;
  bool requested = false, is_output = false, has_edges = false;
  int flags = 0, value = 0;
  std::deque<timespec> edges = {};
};
struct gpiod_chip {
  std::map<unsigned, gpiod_line> lines = {};
};

namespace {

gpiod_chip fake_chip;
std::vector<std::string> calls;
bool chip_is_there = true, lines_fail = false;

int Request(gpiod_line* line, int flags) {
  if (line->requested) {
    errno = EBUSY;
    return -1;
  }
  line->requested = true;
  line->flags = flags;
  return 0;
}

}  // namespace

extern "C" {
gpiod_chip* gpiod_chip_open(const char* path) {
  if (chip_is_there && std::strcmp(path, "/dev/gpiochip0") == 0) return &fake_chip;
  errno = ENOENT;
  return nullptr;
}
void gpiod_chip_close(gpiod_chip*) { calls.emplace_back("close"); }
gpiod_line* gpiod_chip_get_line(gpiod_chip* chip, unsigned number) {
  gpiod_line& line = chip->lines[number];
  line.number = number;
  return &line;
}
int gpiod_line_request_output_flags(gpiod_line* line, const char*, int flags, int value) {
  calls.push_back("output " + std::to_string(line->number) + "=" + std::to_string(value));
  line->is_output = true;
  line->value = value;
  return Request(line, flags);
}
int gpiod_line_request_input_flags(gpiod_line* line, const char*, int flags) {
  calls.push_back("input " + std::to_string(line->number));
  return Request(line, flags);
}
int gpiod_line_request_rising_edge_events_flags(gpiod_line* line, const char*,
                                                int flags) {
  line->has_edges = true;
  return Request(line, flags);
}
int gpiod_line_set_value(gpiod_line* line, int value) {
  if (lines_fail) {
    errno = EIO;
    return -1;
  }
  calls.push_back("set " + std::to_string(line->number) + "=" + std::to_string(value));
  line->value = value;
  return 0;
}
int gpiod_line_get_value(gpiod_line* line) { return lines_fail ? -1 : line->value; }
int gpiod_line_event_wait(gpiod_line* line, const timespec* time) {
  EXPECT_EQ(time->tv_sec + time->tv_nsec, 0) << "no call waits";
  return line->edges.empty() ? 0 : 1;
}
int gpiod_line_event_read(gpiod_line* line, gpiod_line_event* event) {
  event->ts = line->edges.front();
  line->edges.pop_front();
  return 0;
}
}

namespace intaglio::reference_controller {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

class GpioPins : public ::testing::Test {
 protected:
  GpioPins() {
    fake_chip = {};
    calls.clear();
    chip_is_there = true;
    lines_fail = false;
    board = ReadBoardFile(INTAGLIO_SOURCE_DIR "/deploy/boards/els-03.textproto").value();
  }
  LaserBoard board;
};

TEST_F(GpioPins, OutputsAreRequestedOffAndBeforeAnyInputTheQSwitchFirst) {
  const auto pins = OpenGpioPins(BoardLines(board));
  ASSERT_TRUE(pins.has_value()) << pins.error().message;
  const std::vector<std::string> outputs(calls.begin(), calls.begin() + 9);
  EXPECT_THAT(outputs, ElementsAre("output 17=0", "output 5=0", "output 6=0",
                                   "output 13=0", "output 19=0", "output 27=0",
                                   "output 22=0", "output 23=0", "output 24=0"));
  EXPECT_EQ(calls[9], "input 16");
  // What is off with high voltage is pulled there, all else to low.
  EXPECT_EQ(fake_chip.lines[16].flags,
            GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW | GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP);
  EXPECT_EQ(fake_chip.lines[12].flags, GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN);
  for (const unsigned line : {25U, 7U, 8U, 9U, 11U})
    EXPECT_TRUE(fake_chip.lines[line].has_edges) << line;
}

TEST_F(GpioPins, AreSetOnceReadAndSwitchedOffWithTheirObject) {
  auto pins = OpenGpioPins(BoardLines(board)).value();
  calls.clear();
  ASSERT_TRUE(pins->Set(Output::kShutter2, true).has_value());
  ASSERT_TRUE(pins->Set(Output::kShutter2, true).has_value());
  EXPECT_THAT(calls, ElementsAre("set 6=1"));
  EXPECT_EQ(*pins->Levels(), 0u);
  fake_chip.lines[16].value = fake_chip.lines[12].value = 1;
  EXPECT_EQ(*pins->Levels(), BitOf(Input::kKey) | BitOf(Input::kInPosition));
  EXPECT_EQ(*pins->NextEdge(Input::kLampSync), std::nullopt);
  fake_chip.lines[25].edges.push_back({3, 7});
  EXPECT_EQ(*pins->NextEdge(Input::kLampSync), std::chrono::nanoseconds(3'000'000'007));
  EXPECT_EQ(*pins->NextEdge(Input::kLampSync), std::nullopt);
  pins.reset();
  for (const auto& [number, line] : fake_chip.lines) {
    if (!line.is_output) continue;
    EXPECT_EQ(line.value, 0) << number;
  }
  EXPECT_EQ(calls.back(), "close");
}

TEST_F(GpioPins, WhatABoardHasNotIsNeitherSetNorRead) {
  board.clear_photosensors();
  board.clear_door_lock();
  const auto pins = OpenGpioPins(BoardLines(board)).value();
  EXPECT_FALSE(pins->Has(Output::kDoorLock));
  EXPECT_FALSE(pins->Has(Input::kPhotosensor1));
  calls.clear();
  EXPECT_TRUE(pins->Set(Output::kDoorLock, true).has_value());
  EXPECT_TRUE(calls.empty());
  EXPECT_EQ(*pins->NextEdge(Input::kPhotosensor1), std::nullopt);
}

TEST_F(GpioPins, ErrorsNameTheSignalAndItsLine) {
  fake_chip.lines[6].requested = true;
  EXPECT_THAT(OpenGpioPins(BoardLines(board)).error().message,
              HasSubstr("shutters[1], line 6 of /dev/gpiochip0: cannot request the line: "
                        "Device or resource busy"));
  fake_chip = {};
  auto pins = OpenGpioPins(BoardLines(board)).value();
  lines_fail = true;
  EXPECT_THAT(pins->Set(Output::kQSwitch, true).error().message,
              HasSubstr("q_switch, line 17"));
  EXPECT_FALSE(pins->Levels().has_value());
  lines_fail = false;
  chip_is_there = false;
  EXPECT_THAT(OpenGpioPins(BoardLines(board)).error().message,
              HasSubstr("cannot open the chip"));
}

/// The stage of the supplied board.
class GpioStage : public GpioPins {
 protected:
  GpioStage() {
    stage =
        ReadStageBoardFile(INTAGLIO_SOURCE_DIR "/deploy/boards/els-03-stage.textproto")
            .value();
    for (const unsigned line : {34U, 35U, 36U, 40U, 41U}) fake_chip.lines[line].value = 1;
  }
  ControllerTime Time() {
    return {[this] { return now; }, [this](auto until) { now = std::max(now, until); }};
  }

  StageBoard stage;
  std::chrono::nanoseconds now{1'000'000'000};
};

TEST_F(GpioStage, OutputsAreRequestedOffAndBeforeAnyInput) {
  const auto pins = OpenGpioPins(BoardLines(stage));
  ASSERT_TRUE(pins.has_value()) << pins.error().message;
  EXPECT_THAT(calls, ElementsAre("output 28=0", "output 29=0", "output 30=0",
                                 "output 31=0", "output 32=0", "output 33=0",
                                 "output 37=0", "output 38=0", "output 39=0", "input 34",
                                 "input 35", "input 36", "input 40", "input 41"));
  // A cable that is off is a switch that is pressed, a stop, a fault of a drive.
  for (const unsigned line : {34U, 35U, 36U, 40U, 41U}) {
    EXPECT_EQ(fake_chip.lines[line].flags,
              GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW | GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP)
        << line;
    EXPECT_FALSE(fake_chip.lines[line].has_edges) << line;
  }
  EXPECT_FALSE((*pins)->Has(Output::kQSwitch));
  EXPECT_FALSE((*pins)->Has(Input::kKey));
}

TEST_F(GpioStage, EachInputIsReadFromItsLine) {
  const auto pins = OpenGpioPins(BoardLines(stage)).value();
  const std::pair<unsigned, Input> inputs[] = {{34, Input::kFreeX},
                                               {35, Input::kFreeY},
                                               {36, Input::kFreeZ},
                                               {40, Input::kStop},
                                               {41, Input::kDrives}};
  std::uint32_t all = 0;
  for (const auto& [line, input] : inputs) all |= BitOf(input);
  EXPECT_EQ(*pins->Levels(), all);
  for (const auto& [line, input] : inputs) {
    fake_chip.lines[line].value = 0;
    EXPECT_EQ(*pins->Levels(), all & ~BitOf(input)) << line;
    fake_chip.lines[line].value = 1;
  }
}

TEST_F(GpioStage, AxesAreSteppedByTheirLinesTheDirectionFirst) {
  stage.mutable_z()->set_reversed(true);
  auto pins = OpenGpioPins(BoardLines(stage)).value();
  StepAxes axes(OptionsOf(stage, 1).steps, Vec3::Zero(), *pins, Time());
  const auto step_to = [&](const Vec3& to_mm) {
    calls.clear();
    axes.Follow({to_mm, Vec3::Zero(), Vec3::Zero(), Vec3::Zero()}, 0, 0);
    now += std::chrono::milliseconds(1);
    EXPECT_TRUE(axes.Step().has_value());
    EXPECT_TRUE(axes.settled());
  };
  step_to(Vec3(0.005, -0.005, 0.005));
  EXPECT_THAT(calls, ElementsAre("set 29=1", "set 28=1", "set 30=1", "set 32=1",
                                 "set 28=0", "set 30=0", "set 32=0"));
  step_to(Vec3(0.01, 0, 0));
  EXPECT_THAT(calls, ElementsAre("set 31=1", "set 33=1", "set 28=1", "set 30=1",
                                 "set 32=1", "set 28=0", "set 30=0", "set 32=0"));
  step_to(Vec3(0.005, 0, 0));
  EXPECT_THAT(calls, ElementsAre("set 29=0", "set 28=1", "set 28=0"));
}

TEST_F(GpioStage, TheControllerObeysItsInputsAndIsOffWhenTheBoardFails) {
  auto pins = OpenGpioPins(BoardLines(stage)).value();
  auto controller = std::make_unique<StageController>(OptionsOf(stage, 1), *pins, Time());
  const auto turn = [&] {
    now += StageController::kPoll;
    return controller->Turn().has_value();
  };
  ASSERT_TRUE(turn());
  EXPECT_EQ(fake_chip.lines[39].value, 1);
  ASSERT_TRUE(turn());
  EXPECT_EQ(fake_chip.lines[39].value, 0) << "the gate is held open by changes";
  EXPECT_EQ(fake_chip.lines[37].value, 0) << "nobody has homed it";
  EXPECT_EQ(controller->stage().fault(), link::StageFault::kNone);
  fake_chip.lines[41].value = 0;
  ASSERT_TRUE(turn());
  EXPECT_EQ(controller->stage().fault(), link::StageFault::kDriveFault);
  fake_chip.lines[41].value = 1;
  fake_chip.lines[40].value = 0;
  ASSERT_TRUE(turn());
  EXPECT_EQ(controller->stage().fault(), link::StageFault::kStopPressed);
  fake_chip.lines[40].value = 1;
  lines_fail = true;
  EXPECT_FALSE(turn());
  lines_fail = false;
  const std::size_t before = calls.size();
  controller.reset();
  pins.reset();
  for (std::size_t i = before; i < calls.size(); ++i)
    EXPECT_TRUE(calls[i].ends_with("=0") || calls[i] == "close") << calls[i];
  for (const auto& [number, line] : fake_chip.lines) {
    if (!line.is_output) continue;
    EXPECT_EQ(line.value, 0) << number;
  }
}

TEST_F(GpioStage, ErrorsNameTheSignalAndItsLine) {
  fake_chip.lines[30].requested = true;
  EXPECT_THAT(OpenGpioPins(BoardLines(stage)).error().message,
              HasSubstr("y.step, line 30 of /dev/gpiochip0: cannot request the line: "
                        "Device or resource busy"));
}

}  // namespace
}  // namespace intaglio::reference_controller
