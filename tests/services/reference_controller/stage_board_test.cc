#include "services/reference_controller/stage_board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "tests/integration/run_program.h"

namespace intaglio::reference_controller {
namespace {

using ::testing::HasSubstr;

const std::string kSuppliedStage =
    INTAGLIO_SOURCE_DIR "/deploy/boards/els-03-stage.textproto";

/// The errors of the supplied board with a text in place of each that the pattern
/// matches.
std::string StageErrorOf(const std::string& pattern, const std::string& text) {
  const std::string whole = testing::TextIn(kSuppliedStage);
  const std::string changed = std::regex_replace(whole, std::regex(pattern), text);
  EXPECT_NE(changed, whole) << pattern;
  const auto board = ParseStageBoard(changed, "shop.board");
  return board ? "" : board.error().message;
}

TEST(StageBoardFile, TheSuppliedOneIsThatOfThePublishedMachine) {
  const auto board = ReadStageBoardFile(kSuppliedStage);
  ASSERT_TRUE(board.has_value()) << board.error().message;
  const StageControllerOptions options = OptionsOf(*board, 7);
  EXPECT_EQ(options.stage.travel_min_mm, Vec3::Constant(-2));
  EXPECT_EQ(options.stage.travel_max_mm, Vec3::Constant(172));
  EXPECT_EQ(options.stage.max_speed_mm_s, Vec3::Constant(80));
  EXPECT_EQ(options.stage.own_clock->power_up, 7u);
  EXPECT_EQ(options.stage.position_tolerance_mm, 0.03);
  ASSERT_TRUE(options.stage.homing.has_value());
  EXPECT_FALSE(options.stage.homing->axes[0].at_plus_end);
  EXPECT_EQ(options.stage.homing->axes[0].search_mm, 172 + 3 + 5);
  EXPECT_EQ(options.steps.pulse, std::chrono::microseconds(3));
  EXPECT_EQ(options.steps.steps_per_mm, Vec3::Constant(200));
  EXPECT_EQ(BoardLines(*board).size(), 14u);
  EXPECT_EQ(BoardLines(*board).front().name, "x.step");
  // Both are for one board.
  const auto laser = ReadBoardFile(INTAGLIO_SOURCE_DIR "/deploy/boards/els-03.textproto");
  EXPECT_TRUE(CheckLinesApart(*laser, *board).has_value());
}

TEST(StageBoardFile, TheAccelerationOfHomingIsItsOwnOrATenthOfBraking) {
  StageBoard board = ReadStageBoardFile(kSuppliedStage).value();
  board.set_brake_acceleration_mm_s2(6000);
  EXPECT_EQ(OptionsOf(board, 1).stage.homing->acceleration_mm_s2, 600);
  board.set_home_acceleration_mm_s2(50);
  EXPECT_EQ(OptionsOf(board, 1).stage.homing->acceleration_mm_s2, 50);
  EXPECT_EQ(OptionsOf(board, 1).stage.brake_acceleration_mm_s2, 6000);
}

TEST(StageBoardFile, AnAxisThatIsFasterThanItsStepsIsRefusedWithItsRemedy) {
  EXPECT_THAT(
      StageErrorOf("steps_per_mm: 200", "steps_per_mm: 400"),
      HasSubstr("shop.board: x.max_speed_mm_s: 80 mm/s with 400 steps_per_mm are "
                "32000 steps a second, more than max_step_rate_hz, 20000: at most "
                "50 mm/s, or fewer microsteps"));
  EXPECT_THAT(
      StageErrorOf("max_step_rate_hz: 20000", "max_step_rate_hz: 20000 pulse_us: 40"),
      HasSubstr("max_step_rate_hz: 20000 Hz leave no time for a step of 40 us on "
                "and as long off: at most 12500 Hz"));
}

TEST(StageBoardFile, WrongValuesAreNamed) {
  struct Case {
    const char *pattern, *text, *error;
  };
  for (const Case& c : {
           Case{"free \\{ line: 35 active_low: true \\}", "", "y.free: is missing"},
           Case{"switch_mm: -3", "switch_mm: 5", "x.switch_mm: 5 is within the travel"},
           Case{"home_mm: 0", "home_mm: -3", "z.home_mm: -3 is outside the travel"},
           Case{"travel_max_mm: 172", "travel_max_mm: -2",
                "x.travel_max_mm: -2 is not above travel_min_mm, -2"},
           Case{"steps_per_mm: 200", "", "x.steps_per_mm"},
           Case{"stop \\{ line: 40", "stop { line: 41",
                "drives: line 41 of /dev/gpiochip0 is that of stop"},
           Case{"alive \\{ line: 39 \\}", "", "alive: is missing"},
           Case{"in_position_output \\{ line: 38 \\}", "",
                "in_position_output: is missing"},
           Case{"position_tolerance_mm: 0.03", "position_tolerance_mm: 0.006",
                "position_tolerance_mm: 0.006 is below two steps of x, 0.01 mm"},
           Case{"position_tolerance_mm: 0.03", "home_speed_mm_s: 90",
                "home_speed_mm_s: 90 is above max_speed_mm_s of x, 80"},
           Case{"position_tolerance_mm: 0.03", "home_acceleration_mm_s2: 5",
                "home_acceleration_mm_s2: 5 brake from home_speed_mm_s, 10, within 10 mm "
                "behind a switch, more than back_off_mm, 5: at least 10"},
           Case{"position_tolerance_mm: 0.03", "home_acceleration_mm_s2: 0.5",
                "home_acceleration_mm_s2: 0.5 is outside"},
           Case{"position_tolerance_mm", "tolerance_mm", "tolerance_mm"},
       })
    EXPECT_THAT(StageErrorOf(c.pattern, c.text), HasSubstr(c.error)) << c.pattern;
}

TEST(StageBoardFile, ALineOfTheLaserIsNoneOfTheStage) {
  const auto laser = ReadBoardFile(INTAGLIO_SOURCE_DIR "/deploy/boards/els-03.textproto");
  auto stage = ReadStageBoardFile(kSuppliedStage).value();
  stage.mutable_z()->mutable_direction()->set_line(17);
  const Status apart = CheckLinesApart(*laser, stage);
  ASSERT_FALSE(apart.has_value());
  EXPECT_THAT(apart.error().message,
              HasSubstr("z.direction: line 17 of /dev/gpiochip0 is q_switch"));
  stage.set_chip("/dev/gpiochip1");
  EXPECT_TRUE(CheckLinesApart(*laser, stage).has_value());
}

}  // namespace
}  // namespace intaglio::reference_controller
