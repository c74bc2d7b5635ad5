#include "services/drivers/bjjcz/board_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/galvo/files/correction_files.h"
#include "engrave/io/whole_file.h"
#include "services/job/head/point_pulses.h"

namespace intaglio::drivers {
namespace {

using enum LmcOperation;

constexpr std::size_t kMaxCorBytes = 1 << 20;
constexpr int kCorNodesASide = 65;
constexpr double kCorNodePlaces = 1024;  // between two nodes
// Rounding in a file leaves this share of a corrected field's width.
constexpr double kFieldTolerance = 1e-3;
// A list begins with a jump: the rest of its time is for the mark.
constexpr double kMaxJumpSeconds = 0.09;

// What EzCad 2 sends a board; of most only the number is known.
constexpr std::array kBoardSettings = {
    LmcCommand{kEnableLaser, {}},
    LmcCommand{kControlMode, {0}},
    LmcCommand{kLaserMode, {1}},
    LmcCommand{kDelayMode, {1}},
    LmcCommand{kTiming, {1}},
    LmcCommand{kStandby, {2000, 20}},
    LmcCommand{kFirstPulse, {200}},
    LmcCommand{kPwmHalfPeriod, {125}},
    LmcCommand{kPwmPulseWidth, {125}},
    LmcCommand{kFibreOscillator, {0}},
    LmcCommand{kFirstPulseKiller, {0xFFB, 1, 409, 100}},
    LmcCommand{kFlyResolution, {0, 99, 1000, 25}},
    LmcCommand{kEnableZ, {}},
    LmcCommand{kAnalogPort1, {0x7FF}},
    LmcCommand{kEnableZ, {}},
};

class BoardErrors {
 public:
  void Missing(const char* field, const char* remedy) {
    errors_.push_back(
        {ErrorCode::kMissing, fmt::format("{}: is missing; {}", field, remedy), ""});
  }
  void Wrong(std::string sentence) {
    errors_.push_back({ErrorCode::kInvalidValue, std::move(sentence), ""});
  }
  std::vector<Error> errors_;
};

void CheckBoard(const MachineSpec& machine, BoardErrors& errors) {
  if (!machine.has_bjjcz_board()) {
    return errors.Missing("bjjcz_board",
                          "the protocol bjjcz needs laser and door_input "
                          "(deploy/machines/bjjcz-uv.textproto)");
  }
  const BjjczBoard& board = machine.bjjcz_board();
  if (board.laser() == BJJCZ_LASER_UNSPECIFIED || !BjjczLaser_IsValid(board.laser()))
    errors.Missing("bjjcz_board.laser",
                   "give BJJCZ_LASER_FIBRE, BJJCZ_LASER_CO2 or BJJCZ_LASER_UV");
  if (!board.has_door_input())
    errors.Missing("bjjcz_board.door_input",
                   "give the input that is high while key, door and stop button are "
                   "closed");
  if (board.has_pulse_width_ns() && board.laser() != BJJCZ_LASER_FIBRE)
    errors.Wrong(
        fmt::format("bjjcz_board.pulse_width_ns: {:g} is of a fibre laser; "
                    "remove it",
                    board.pulse_width_ns()));
  const auto gate = board.gate_output();
  if ((board.has_lamp_output() && board.lamp_output() == gate) ||
      (board.has_guide_output() && board.guide_output() == gate))
    errors.Wrong(
        fmt::format("bjjcz_board.gate_output: {} is also another output; the "
                    "gate of the laser needs one of its own",
                    gate));
}

void CheckHead(const ScanHead& head, BoardErrors& errors) {
  if (!(head.field_mm() > 0))
    errors.Missing("scan_head.field_mm", "give the width of the field, mm");
  if (!(head.jump_mm_s() > 0))
    return errors.Missing("scan_head.jump_mm_s", "give the speed of jumps, mm/s");
  const double jump_s =
      std::sqrt(2) * head.field_mm() / head.jump_mm_s() + head.jump_delay_s();
  if (jump_s > kMaxJumpSeconds) {
    errors.Wrong(fmt::format(
        "scan_head.jump_mm_s: {:g}; a jump across the field takes {:.3f} s, at most "
        "{:g} s is possible, since the board ends what it has without a host; jump "
        "faster",
        head.jump_mm_s(), jump_s, kMaxJumpSeconds));
  }
  const auto refuse = [&](bool has, const char* field) {
    if (has)
      errors.Wrong(
          fmt::format("scan_head.{}: is of a head that is driven tick by tick, "
                      "and a BJJCZ board drives its mirrors; remove it",
                      field));
  };
  refuse(head.servo_lag_s() != 0, "servo_lag_s");
  refuse(head.has_run_in_s() && head.run_in_s() != 0, "run_in_s");
  refuse(head.has_lead_servo() && head.lead_servo(), "lead_servo");
  refuse(head.encoder_count_um() != 0, "encoder_count_um");
  refuse(head.has_ahead_ms(), "ahead_ms");
  refuse(head.has_eye_mm(), "eye_mm");
}

void CheckPoints(const MachineSpec& machine, BoardErrors& errors) {
  if (!(machine.scan_head().field_mm() > 0))
    errors.Missing("scan_head.field_mm", "give the width of the field, mm");
  if (!machine.bjjcz_board().has_point_frequency_hz())
    errors.Missing("bjjcz_board.point_frequency_hz",
                   "give the frequency of the laser's pulses at a point");
  if (!machine.laser().has_max_unsettled_points())
    errors.Missing("laser.max_unsettled_points",
                   "give how many points a list may have: so many become uncertain "
                   "when all fails at once, 32");
  if (!(machine.z().steps_per_mm() > 0))
    errors.Missing("z.steps_per_mm", "give the steps of the board's axis for 1 mm");
  if (!machine.head_over_block().has_jump_and_dwell())
    return errors.Missing("head_over_block.jump_and_dwell",
                          "a BJJCZ board jumps to a point and dwells there: give its "
                          "times");
  const JumpAndDwell& jumps = machine.head_over_block().jump_and_dwell();
  if (!(jumps.jump_mm_s() > 0)) return;  // named with the other fields
  const double point_s = LongestPointSeconds(machine, jumps.dwell_s());
  if (point_s > kMaxBoardPointSeconds) {
    errors.Wrong(fmt::format(
        "head_over_block.jump_and_dwell: a jump across the field with its delay and "
        "dwell takes {:.3f} s, at most {:g} s is possible, since the board ends what it "
        "has without a host; jump faster, or dwell for a shorter time",
        point_s, kMaxBoardPointSeconds));
  }
}

Result<std::vector<LmcCommand>> CorrectionLinesOf(const ScanHead& head) {
  const std::string& file = head.correction_file();
  if (file.empty()) return std::vector{LmcCommand{kCorrectionTable, {0}}};
  const auto named = [](Error error) {
    error.message = "scan_head.correction_file: " + error.message;
    return error;
  };
  if (!file.ends_with(".cor")) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("scan_head.correction_file: '{}' is no .cor file, which a "
                            "BJJCZ board takes; give one",
                            file),
                file);
  }
  const std::string bytes =
      INTAGLIO_TRY(io::ReadWholeFile(file, kMaxCorBytes).map_error(named));
  const galvo::FieldGrid grid =
      INTAGLIO_TRY(galvo::ReadCor(bytes, file).map_error(named));
  const double field_mm = (kCorNodesASide - 1) * grid.pitch_mm;
  if (std::abs(field_mm - head.field_mm()) > kFieldTolerance * field_mm) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("scan_head.field_mm: {:g}, and the correction_file '{}' is of "
                    "a field of {:.3f} mm; give this width",
                    head.field_mm(), file, field_mm),
        fmt::format("{}", head.field_mm()));
  }
  std::vector<LmcCommand> lines = {{kCorrectionTable, {1}}};
  for (const Vec2& by_mm : grid.values_mm) {
    const Vec2 by = by_mm * (kCorNodePlaces / grid.pitch_mm);
    const std::uint16_t behind_first = lines.size() > 1 ? 1 : 0;
    lines.push_back(
        {kCorrectionLine,
         {SignedNumber(static_cast<int>(std::lround(by.x()))),
          SignedNumber(static_cast<int>(std::lround(by.y()))), behind_first}});
  }
  return lines;
}

}  // namespace

std::vector<Error> CheckBjjczProfile(const MachineSpec& machine) {
  BoardErrors errors;
  CheckBoard(machine, errors);
  CheckHead(machine.scan_head(), errors);
  if (errors.errors_.empty()) {
    if (const auto lines = CorrectionLinesOf(machine.scan_head()); !lines)
      errors.errors_.push_back(lines.error());
  }
  return std::move(errors.errors_);
}

std::vector<Error> CheckBjjczPointProfile(const MachineSpec& machine) {
  BoardErrors errors;
  CheckBoard(machine, errors);
  CheckPoints(machine, errors);
  if (errors.errors_.empty()) {
    if (const auto lines = CorrectionLinesOf(machine.scan_head()); !lines)
      errors.errors_.push_back(lines.error());
  }
  return std::move(errors.errors_);
}

Result<std::vector<LmcCommand>> BoardSetUp(const MachineSpec& machine) {
  std::vector<LmcCommand> all = {{kStopExecute, {}},
                                 {kFibreOscillator, {0}},
                                 {kResetList, {}},
                                 {kWritePort, {0}},
                                 {kReset, {}}};
  const auto lines = INTAGLIO_TRY(CorrectionLinesOf(machine.scan_head()));
  all.insert(all.end(), lines.begin(), lines.end());
  all.insert(all.end(), kBoardSettings.begin(), kBoardSettings.end());
  return all;
}

}  // namespace intaglio::drivers
