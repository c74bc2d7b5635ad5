#include "services/reference_controller/board_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio::reference_controller {
namespace {

using ::testing::HasSubstr;

constexpr const char* kWhole = R"(
  q_switch { line: 4 } shutters { line: 5 } shutters { line: 6 } lamp { line: 7 }
  lamp_trigger { line: 8 } alive { line: 9 } key { line: 10 } door { line: 11 }
  stop { line: 12 } in_position { line: 13 }
)";

std::string ErrorOf(const std::string& text) {
  const auto board = ParseBoard(text, "shop.board");
  return board ? "" : board.error().message;
}

TEST(BoardFile, TheSuppliedOneHasAllSignalsOfThePublishedMachine) {
  const auto board = ReadBoardFile(INTAGLIO_SOURCE_DIR "/deploy/boards/els-03.textproto");
  ASSERT_TRUE(board.has_value()) << board.error().message;
  const ControllerOptions options = OptionsOf(*board, 7);
  EXPECT_EQ(options.laser.channels, 4);
  EXPECT_EQ(board->photosensors_size(), 4);
  EXPECT_TRUE(board->has_lamp_sync());
  EXPECT_EQ(options.laser.rates_hz.back(), 200);
  EXPECT_EQ(options.laser.signals.trigger_max_delay_us, 20);
  EXPECT_TRUE(options.laser.locks_door);
  EXPECT_FALSE(options.laser.measures_energy);
  EXPECT_EQ(options.laser.power_up, 7u);
  // Outputs come first, the one that fires before all others.
  const auto lines = BoardLines(*board);
  ASSERT_EQ(lines.size(), 18u);
  EXPECT_EQ(lines.front().name, "q_switch");
  EXPECT_EQ(lines.front().line.chip(), "/dev/gpiochip0");
}

TEST(BoardFile, DefaultsAreThoseOfTheFields) {
  const auto board = ParseBoard(kWhole, "shop.board");
  ASSERT_TRUE(board.has_value()) << board.error().message;
  const ControllerOptions options = OptionsOf(*board, 1);
  EXPECT_EQ(options.laser.rates_hz, std::vector<double>{100});
  EXPECT_EQ(options.laser.warm_up_s, 30);
  EXPECT_EQ(options.laser.max_energy_mj, 30);
  EXPECT_EQ(options.laser.min_energy_mj, 30);
  EXPECT_EQ(options.sensor_window, std::chrono::microseconds(300));
  EXPECT_FALSE(options.laser.locks_door);
}

TEST(BoardFile, LinesForOtherUsesAreCounted) {
  const auto board =
      ParseBoard(std::string(kWhole) +
                     "outputs { line: 20 } outputs { line: 21 } inputs { line: 22 }",
                 "shop.board");
  ASSERT_TRUE(board.has_value()) << board.error().message;
  const ControllerOptions options = OptionsOf(*board, 1);
  EXPECT_EQ(options.laser.output_count, 2u);
  EXPECT_EQ(options.laser.inputs.size(), 1u);
}

TEST(BoardFile, WhatIsWrongIsNamedWithItsField) {
  EXPECT_THAT(ErrorOf(""), HasSubstr("shop.board: q_switch: is missing"));
  EXPECT_THAT(ErrorOf(""), HasSubstr("shop.board: alive: is missing"));
  const std::string whole = kWhole;
  EXPECT_THAT(ErrorOf(whole + "photosensors { line: 14 }"),
              HasSubstr("photosensors: 1 for 2 shutters"));
  EXPECT_THAT(ErrorOf(whole + "lamp_sync { line: 4 }"),
              HasSubstr("lamp_sync: line 4 of /dev/gpiochip0 is that of q_switch"));
  EXPECT_EQ(ErrorOf(whole + "lamp_sync { line: 4 chip: \"/dev/gpiochip1\" }"), "");
  EXPECT_THAT(ErrorOf(whole + "rates_hz: 1e4"),
              HasSubstr("rates_hz[0]: 10000 is outside"));
  EXPECT_THAT(ErrorOf(whole + "pulse_energy_mj: nan"), HasSubstr("pulse_energy_mj"));
  EXPECT_THAT(ErrorOf(whole + "qswitch { line: 1 }"), HasSubstr("shop.board:"));
  std::string nine;
  for (int i = 0; i < 9; ++i) nine += "inputs { line: " + std::to_string(20 + i) + " }";
  EXPECT_THAT(ErrorOf(whole + nine), HasSubstr("inputs: 9 are more than 8"));
  EXPECT_THAT(ErrorOf(whole + "outputs { line: 4 }"),
              HasSubstr("outputs[0]: line 4 of /dev/gpiochip0 is that of q_switch"));
  std::string flashes_itself = whole + "lamp_sync { line: 14 } rates_hz: [100, 200]";
  flashes_itself.erase(flashes_itself.find("lamp_trigger"),
                       sizeof "lamp_trigger { line: 8 }");
  EXPECT_THAT(ErrorOf(flashes_itself),
              HasSubstr("rates_hz: 2 rates, and no lamp_trigger"));
}

}  // namespace
}  // namespace intaglio::reference_controller
