#include "services/reference_controller/stage_board.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "services/platform/fields/field_defaults.h"

namespace intaglio::reference_controller {
namespace {

using std::chrono::nanoseconds;

// An axis may be so far beyond its travel that it is on its switch, and a little more.
constexpr double kSearchBeyondMm = 5;
constexpr std::uint32_t kQueueCapacity = 4096;

std::array<const StageAxisBoard*, 3> AxesOf(const StageBoard& board) {
  return {&board.x(), &board.y(), &board.z()};
}

/// `board` has its defaults.
double HomeAccelerationOf(const StageBoard& board) {
  return board.has_home_acceleration_mm_s2() ? board.home_acceleration_mm_s2()
                                             : board.brake_acceleration_mm_s2() / 10;
}

nanoseconds Microseconds(double us) {
  return nanoseconds(static_cast<std::int64_t>(1000 * us));
}

class StageBoardChecker {
 public:
  explicit StageBoardChecker(const StageBoard& given)
      : faults_(given), board_(WithDefaults(given)) {}

  std::vector<Error> Check() && {
    faults_.Need(board_.has_in_position_output(), "in_position_output",
                 "the laser's board reads it");
    faults_.Need(board_.has_alive(), "alive", "it holds the hardware gate open");
    faults_.Need(board_.has_stop(), "stop", "nothing moves without it");
    for (int axis = 0; axis < 3; ++axis)
      CheckAxis(std::string(1, "xyz"[axis]),
                *AxesOf(board_)[static_cast<std::size_t>(axis)]);
    const double shortest_us = 2 * board_.pulse_us();
    if (shortest_us * board_.max_step_rate_hz() > 1e6) {
      faults_.Add(
          fmt::format("max_step_rate_hz: {} Hz leave no time for a step of {} us on and "
                      "as long off: at "
                      "most {:.0f} Hz",
                      board_.max_step_rate_hz(), board_.pulse_us(), 1e6 / shortest_us));
    }
    CheckHomeAcceleration();
    faults_.CheckSerialNumber(board_.serial_number());
    faults_.CheckLines(BoardLines(board_));
    return std::move(faults_).Errors();
  }

 private:
  // What is passed behind a switch before the axis rests is room that the machine has.
  void CheckHomeAcceleration() {
    if (!board_.has_home_acceleration_mm_s2()) return;
    const double speed_mm_s = board_.home_speed_mm_s();
    const double overrun_mm =
        speed_mm_s * speed_mm_s / (2 * board_.home_acceleration_mm_s2());
    if (overrun_mm <= board_.back_off_mm()) return;
    faults_.Add(fmt::format(
        "home_acceleration_mm_s2: {} brake from home_speed_mm_s, {}, within {:.4g} mm "
        "behind a switch, more than back_off_mm, {}: at least {:.4g}, or a lower speed",
        board_.home_acceleration_mm_s2(), speed_mm_s, overrun_mm, board_.back_off_mm(),
        speed_mm_s * speed_mm_s / (2 * board_.back_off_mm())));
  }

  static StageBoard WithDefaults(StageBoard board) {
    FillDefaults(board);
    return board;
  }

  void CheckAxis(const std::string& name, const StageAxisBoard& axis) {
    const auto need = [&](bool given, const char* field, const char* why) {
      faults_.Need(given, fmt::format("{}.{}", name, field), why);
    };
    need(axis.has_step(), "step", "the motor is moved by it");
    need(axis.has_direction(), "direction", "the motor needs it");
    need(axis.has_free(), "free", "the place of the axis is found by its switch");
    if (!(axis.travel_min_mm() < axis.travel_max_mm())) {
      faults_.Add(fmt::format("{}.travel_max_mm: {} is not above travel_min_mm, {}", name,
                              axis.travel_max_mm(), axis.travel_min_mm()));
    }
    if (axis.switch_mm() >= axis.travel_min_mm() &&
        axis.switch_mm() <= axis.travel_max_mm()) {
      faults_.Add(fmt::format(
          "{}.switch_mm: {} is within the travel, {} to {}: the switch is outside it",
          name, axis.switch_mm(), axis.travel_min_mm(), axis.travel_max_mm()));
    }
    if (axis.home_mm() < axis.travel_min_mm() || axis.home_mm() > axis.travel_max_mm()) {
      faults_.Add(fmt::format("{}.home_mm: {} is outside the travel, {} to {}", name,
                              axis.home_mm(), axis.travel_min_mm(),
                              axis.travel_max_mm()));
    }
    CheckSteps(name, axis);
  }

  void CheckSteps(const std::string& name, const StageAxisBoard& axis) {
    const double rate_hz = axis.max_speed_mm_s() * axis.steps_per_mm();
    if (rate_hz > board_.max_step_rate_hz()) {
      faults_.Add(fmt::format(
          "{}.max_speed_mm_s: {} mm/s with {} steps_per_mm are {:.0f} steps a second, "
          "more "
          "than max_step_rate_hz, {}: at most {:.4g} mm/s, or fewer microsteps",
          name, axis.max_speed_mm_s(), axis.steps_per_mm(), rate_hz,
          board_.max_step_rate_hz(), board_.max_step_rate_hz() / axis.steps_per_mm()));
    }
    for (const auto& [field, speed_mm_s] :
         {std::pair{"home_speed_mm_s", board_.home_speed_mm_s()},
          std::pair{"touch_speed_mm_s", board_.touch_speed_mm_s()}}) {
      if (speed_mm_s <= axis.max_speed_mm_s()) continue;
      faults_.Add(fmt::format("{}: {} is above max_speed_mm_s of {}, {}", field,
                              speed_mm_s, name, axis.max_speed_mm_s()));
    }
    const double step_mm = axis.steps_per_mm() > 0 ? 1 / axis.steps_per_mm() : 0;
    for (const auto& [field, mm] :
         {std::pair{"position_tolerance_mm", board_.position_tolerance_mm()},
          std::pair{"following_error_limit_mm", board_.following_error_limit_mm()}}) {
      if (mm >= 2 * step_mm) continue;
      faults_.Add(fmt::format("{}: {} is below two steps of {}, {:.4g} mm", field, mm,
                              name, 2 * step_mm));
    }
  }

  BoardFaults faults_;
  StageBoard board_;
};

}  // namespace

std::vector<Error> CheckStageBoard(const StageBoard& board) {
  return StageBoardChecker(board).Check();
}

Result<StageBoard> ParseStageBoard(std::string_view text, const std::string& name) {
  StageBoard board;
  INTAGLIO_TRY(
      ParseBoardText(text, name, "a board file (proto/stage_board.proto)", board));
  INTAGLIO_TRY(JoinFaults(name, CheckStageBoard(board)));
  return board;
}

Result<StageBoard> ReadStageBoardFile(const std::filesystem::path& file) {
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxBoardFileBytes));
  return ParseStageBoard(text, file.string());
}

Status CheckLinesApart(const LaserBoard& laser, const StageBoard& stage) {
  for (const NamedLine& of_stage : BoardLines(stage)) {
    for (const NamedLine& of_laser : BoardLines(laser)) {
      if (of_stage.line.chip() != of_laser.line.chip() ||
          of_stage.line.line() != of_laser.line.line())
        continue;
      return Fail(
          ErrorCode::kInvalidValue,
          fmt::format("{}: line {} of {} is {} of the laser's board file", of_stage.name,
                      of_stage.line.line(), of_stage.line.chip(), of_laser.name),
          of_stage.name);
    }
  }
  return {};
}

StageControllerOptions OptionsOf(const StageBoard& given, std::uint32_t power_up) {
  StageBoard board = given;
  FillDefaults(board);
  StageControllerOptions options;
  virtual_engraver::StageOptions& stage = options.stage;
  virtual_engraver::HomingOptions homing;
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const StageAxisBoard& axis = *AxesOf(board)[at];
    stage.travel_min_mm[i] = axis.travel_min_mm();
    stage.travel_max_mm[i] = axis.travel_max_mm();
    stage.start_mm[i] = axis.home_mm();
    stage.max_speed_mm_s[i] = axis.max_speed_mm_s();
    options.steps.steps_per_mm[i] = axis.steps_per_mm();
    options.steps.reversed[at] = axis.reversed();
    const bool at_plus_end = axis.switch_mm() > axis.travel_max_mm();
    const double far_mm = at_plus_end ? axis.travel_min_mm() : axis.travel_max_mm();
    homing.axes[at] = {at_plus_end, axis.switch_mm(),
                       std::abs(axis.switch_mm() - far_mm) + kSearchBeyondMm};
  }
  homing.speed_mm_s = board.home_speed_mm_s();
  homing.touch_speed_mm_s = board.touch_speed_mm_s();
  homing.back_off_mm = board.back_off_mm();
  homing.acceleration_mm_s2 = HomeAccelerationOf(board);
  stage.homing = homing;
  stage.mechanics.lag_s = 0;
  stage.position_tolerance_mm = board.position_tolerance_mm();
  stage.following_error_limit_mm = board.following_error_limit_mm();
  stage.brake_acceleration_mm_s2 = board.brake_acceleration_mm_s2();
  stage.queue_capacity = kQueueCapacity;
  stage.own_clock = virtual_engraver::OwnClockOptions{0, 0, power_up, 0};
  stage.serial_number = board.serial_number();
  options.steps.max_rate_hz = board.max_step_rate_hz();
  options.steps.pulse = Microseconds(board.pulse_us());
  options.steps.direction_setup = Microseconds(board.direction_setup_us());
  return options;
}

}  // namespace intaglio::reference_controller
