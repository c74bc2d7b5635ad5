#include "services/reference_controller/board_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "services/platform/fields/field_defaults.h"
#include "services/platform/text_format/text_format.h"

namespace intaglio::reference_controller {
namespace {

// The messages nest two deep.
constexpr int kMaxDepth = 8;
// What a laser controller's identity can list and report
// (services/platform/link/laser_protocol.h).
constexpr int kMaxRates = 32;
constexpr std::size_t kMaxSerialNumber = 64;
constexpr int kMaxChannels = 4;

class BoardChecker {
 public:
  explicit BoardChecker(const LaserBoard& board) : board_(board) {
    for (NumberFault& fault : NumbersOutOfRange(board, ""))
      errors_.push_back(std::move(fault.error));
  }

  void CheckNeeded() {
    const auto need = [this](bool given, const char* field, const char* why) {
      if (!given) Add(ErrorCode::kMissing, fmt::format("{}: is missing: {}", field, why));
    };
    need(board_.has_q_switch(), "q_switch", "without it nothing can fire");
    need(board_.shutters_size() > 0, "shutters", "name one for each channel");
    need(board_.has_lamp(), "lamp", "without it the lamp cannot be switched off");
    need(board_.has_alive(), "alive", "it holds the hardware gate open");
    need(board_.has_key(), "key", "nothing fires without it");
    need(board_.has_door(), "door", "nothing fires without it");
    need(board_.has_stop(), "stop", "nothing fires without it");
    need(board_.has_in_position(), "in_position", "it is the gate of every point");
    need(board_.has_lamp_trigger() || board_.has_lamp_sync(), "lamp_trigger",
         "name it, or lamp_sync of a laser that flashes by itself");
  }

  void CheckCounts() {
    const int channels = board_.shutters_size(), sensors = board_.photosensors_size();
    if (channels > kMaxChannels)
      Add(ErrorCode::kInvalidValue,
          fmt::format("shutters: {} are more than 4", channels));
    if (sensors != 0 && sensors != channels) {
      Add(ErrorCode::kInvalidValue,
          fmt::format("photosensors: {} for {} shutters: name one for each, or none",
                      sensors, channels));
    }
    if (board_.rates_hz_size() > kMaxRates) {
      Add(ErrorCode::kInvalidValue, fmt::format("rates_hz: {} rates are more than {}",
                                                board_.rates_hz_size(), kMaxRates));
    }
    if (!board_.has_lamp_trigger() && board_.rates_hz_size() > 1) {
      Add(ErrorCode::kInvalidValue,
          fmt::format("rates_hz: {} rates, and no lamp_trigger to make them: name the "
                      "rate at which the laser flashes",
                      board_.rates_hz_size()));
    }
  }

  void CheckSerialNumber() {
    const std::string& text = board_.serial_number();
    const bool printable = std::all_of(text.begin(), text.end(),
                                       [](char c) { return c >= ' ' && c <= '~'; });
    if (printable && text.size() <= kMaxSerialNumber) return;
    Add(ErrorCode::kInvalidValue,
        fmt::format("serial_number: {:?} is not 0 to 64 printable ASCII characters",
                    text));
  }

  /// Two signals on one line would switch each other.
  void CheckLines() {
    std::map<std::pair<std::string, std::uint32_t>, std::string> taken;
    for (const auto& [name, line] : BoardLines(board_)) {
      const auto [at, fresh] = taken.try_emplace({line.chip(), line.line()}, name);
      if (fresh) continue;
      Add(ErrorCode::kInvalidValue, fmt::format("{}: line {} of {} is that of {}", name,
                                                line.line(), line.chip(), at->second));
    }
  }

  std::vector<Error> Errors() && { return std::move(errors_); }

 private:
  void Add(ErrorCode code, std::string what) {
    errors_.push_back({code, std::move(what), ""});
  }

  const LaserBoard& board_;
  std::vector<Error> errors_;
};

}  // namespace

std::vector<NamedLine> BoardLines(const LaserBoard& board) {
  std::vector<NamedLine> lines;
  const std::string chip = board.chip().empty() ? "/dev/gpiochip0" : board.chip();
  const auto add = [&](std::string name, const BoardLine& line) {
    lines.push_back({std::move(name), line});
    if (line.chip().empty()) lines.back().line.set_chip(chip);
  };
  const google::protobuf::Reflection& reflection = *LaserBoard::GetReflection();
  std::vector<const google::protobuf::FieldDescriptor*> fields;
  reflection.ListFields(board, &fields);
  for (const auto* field : fields) {
    if (field->message_type() != BoardLine::descriptor()) continue;
    const int count = field->is_repeated() ? reflection.FieldSize(board, field) : 1;
    for (int i = 0; i < count; ++i) {
      const auto& line = static_cast<const BoardLine&>(
          field->is_repeated() ? reflection.GetRepeatedMessage(board, field, i)
                               : reflection.GetMessage(board, field));
      add(field->is_repeated() ? fmt::format("{}[{}]", field->name(), i) : field->name(),
          line);
    }
  }
  return lines;
}

std::vector<Error> CheckBoard(const LaserBoard& board) {
  BoardChecker checker(board);
  checker.CheckNeeded();
  checker.CheckCounts();
  checker.CheckSerialNumber();
  checker.CheckLines();
  return std::move(checker).Errors();
}

Result<LaserBoard> ParseBoard(std::string_view text, const std::string& name) {
  INTAGLIO_TRY(CheckTextSize(text, name, kMaxBoardFileBytes,
                             "a board file (proto/laser_board.proto)"));
  LaserBoard board;
  INTAGLIO_TRY(ParseTextFormat(text, name, kMaxDepth, board));
  std::string wrong;
  for (const Error& error : CheckBoard(board))
    wrong += fmt::format("{}{}: {}", wrong.empty() ? "" : "\n", name, error.message);
  if (!wrong.empty()) return Fail(ErrorCode::kInvalidValue, wrong);
  return board;
}

Result<LaserBoard> ReadBoardFile(const std::filesystem::path& file) {
  const auto text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxBoardFileBytes));
  return ParseBoard(text, file.string());
}

ControllerOptions OptionsOf(const LaserBoard& given, std::uint32_t power_up) {
  LaserBoard board = given;
  FillDefaults(board);
  ControllerOptions options;
  virtual_engraver::LaserOptions& laser = options.laser;
  laser.rates_hz.assign(board.rates_hz().begin(), board.rates_hz().end());
  laser.warm_up_s = board.warm_up_s();
  laser.channels = static_cast<std::uint8_t>(board.shutters_size());
  laser.power_up = power_up;
  laser.serial_number = board.serial_number();
  laser.model = "Intaglio reference controller";
  laser.fires_at_place = false;
  laser.measures_energy = false;
  laser.signals.trigger_max_delay_us = board.trigger_max_delay_us();
  laser.signals.trigger_min_width_us = board.trigger_min_width_us();
  laser.signals.sync_width_us = board.sync_width_us();
  laser.signals.sensor_width_us = board.sensor_width_us();
  laser.signals.shutter_time_s = board.shutter_time_ms() / 1000;
  laser.min_energy_mj = laser.max_energy_mj = board.pulse_energy_mj();
  laser.locks_door = board.has_door_lock();
  options.sensor_window = std::chrono::nanoseconds(
      static_cast<std::int64_t>(1000 * board.sensor_window_us()));
  return options;
}

}  // namespace intaglio::reference_controller
