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
constexpr int kMaxSpare = link::kMaxAccessories;

class BoardChecker {
 public:
  explicit BoardChecker(const LaserBoard& board) : board_(board), faults_(board) {}

  std::vector<Error> Check() && {
    CheckNeeded();
    CheckCounts();
    faults_.CheckSerialNumber(board_.serial_number());
    faults_.CheckLines(BoardLines(board_));
    return std::move(faults_).Errors();
  }

 private:
  void CheckNeeded() {
    faults_.Need(board_.has_q_switch(), "q_switch", "without it nothing can fire");
    faults_.Need(board_.shutters_size() > 0, "shutters", "name one for each channel");
    faults_.Need(board_.has_lamp(), "lamp", "without it the lamp cannot be switched off");
    faults_.Need(board_.has_alive(), "alive", "it holds the hardware gate open");
    faults_.Need(board_.has_key(), "key", "nothing fires without it");
    faults_.Need(board_.has_door(), "door", "nothing fires without it");
    faults_.Need(board_.has_stop(), "stop", "nothing fires without it");
    faults_.Need(board_.has_in_position(), "in_position",
                 "it is the gate of every point");
    faults_.Need(board_.has_lamp_trigger() || board_.has_lamp_sync(), "lamp_trigger",
                 "name it, or lamp_sync of a laser that flashes by itself");
  }

  void CheckCounts() {
    const int channels = board_.shutters_size(), sensors = board_.photosensors_size();
    if (channels > kMaxChannels)
      faults_.Add(fmt::format("shutters: {} are more than 4", channels));
    if (sensors != 0 && sensors != channels) {
      faults_.Add(
          fmt::format("photosensors: {} for {} shutters: name one for each, or none",
                      sensors, channels));
    }
    for (const auto& [count, field] : {std::pair(board_.outputs_size(), "outputs"),
                                       std::pair(board_.inputs_size(), "inputs")}) {
      if (count > kMaxSpare)
        faults_.Add(fmt::format("{}: {} are more than {}", field, count, kMaxSpare));
    }
    if (board_.rates_hz_size() > kMaxRates) {
      faults_.Add(fmt::format("rates_hz: {} rates are more than {}",
                              board_.rates_hz_size(), kMaxRates));
    }
    if (!board_.has_lamp_trigger() && board_.rates_hz_size() > 1) {
      faults_.Add(
          fmt::format("rates_hz: {} rates, and no lamp_trigger to make them: name the "
                      "rate at which the laser flashes",
                      board_.rates_hz_size()));
    }
  }

  const LaserBoard& board_;
  BoardFaults faults_;
};

void AddLines(const google::protobuf::Message& message, const std::string& path,
              const std::string& chip, std::vector<NamedLine>& lines) {
  const google::protobuf::Reflection& reflection = *message.GetReflection();
  std::vector<const google::protobuf::FieldDescriptor*> fields;
  reflection.ListFields(message, &fields);
  for (const auto* field : fields) {
    if (field->message_type() == nullptr) continue;
    const int count = field->is_repeated() ? reflection.FieldSize(message, field) : 1;
    for (int i = 0; i < count; ++i) {
      const google::protobuf::Message& part =
          field->is_repeated() ? reflection.GetRepeatedMessage(message, field, i)
                               : reflection.GetMessage(message, field);
      const std::string name =
          JoinPath(path, field->is_repeated() ? fmt::format("{}[{}]", field->name(), i)
                                              : field->name());
      if (field->message_type() != BoardLine::descriptor()) {
        AddLines(part, name, chip, lines);
        continue;
      }
      lines.push_back({name, static_cast<const BoardLine&>(part)});
      if (lines.back().line.chip().empty()) lines.back().line.set_chip(chip);
    }
  }
}

}  // namespace

std::vector<NamedLine> BoardLines(const google::protobuf::Message& board) {
  const auto* field = board.GetDescriptor()->FindFieldByName("chip");
  const std::string chip = board.GetReflection()->GetString(board, field);
  std::vector<NamedLine> lines;
  AddLines(board, "", chip.empty() ? "/dev/gpiochip0" : chip, lines);
  return lines;
}

BoardFaults::BoardFaults(const google::protobuf::Message& board) {
  for (NumberFault& fault : NumbersOutOfRange(board, ""))
    errors_.push_back(std::move(fault.error));
}

void BoardFaults::Add(std::string what, ErrorCode code) {
  errors_.push_back({code, std::move(what), ""});
}

void BoardFaults::Need(bool given, const std::string& field, const char* why) {
  if (!given) Add(fmt::format("{}: is missing: {}", field, why), ErrorCode::kMissing);
}

void BoardFaults::CheckSerialNumber(const std::string& text) {
  const bool printable =
      std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
  if (printable && text.size() <= kMaxSerialNumber) return;
  Add(fmt::format("serial_number: {:?} is not 0 to 64 printable ASCII characters", text));
}

void BoardFaults::CheckLines(const std::vector<NamedLine>& lines) {
  std::map<std::pair<std::string, std::uint32_t>, std::string> taken;
  for (const auto& [name, line] : lines) {
    const auto [at, fresh] = taken.try_emplace({line.chip(), line.line()}, name);
    if (fresh) continue;
    Add(fmt::format("{}: line {} of {} is that of {}", name, line.line(), line.chip(),
                    at->second));
  }
}

Status JoinFaults(const std::string& name, const std::vector<Error>& faults) {
  std::string wrong;
  for (const Error& error : faults)
    wrong += fmt::format("{}{}: {}", wrong.empty() ? "" : "\n", name, error.message);
  if (wrong.empty()) return {};
  return Fail(ErrorCode::kInvalidValue, wrong);
}

Status ParseBoardText(std::string_view text, const std::string& name, const char* what,
                      google::protobuf::Message& board) {
  INTAGLIO_TRY(CheckTextSize(text, name, kMaxBoardFileBytes, what));
  INTAGLIO_TRY(ParseTextFormat(text, name, kMaxDepth, board));
  return {};
}

std::vector<Error> CheckBoard(const LaserBoard& board) {
  return BoardChecker(board).Check();
}

Result<LaserBoard> ParseBoard(std::string_view text, const std::string& name) {
  LaserBoard board;
  INTAGLIO_TRY(
      ParseBoardText(text, name, "a board file (proto/laser_board.proto)", board));
  INTAGLIO_TRY(JoinFaults(name, CheckBoard(board)));
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
  laser.output_count = static_cast<std::size_t>(board.outputs_size());
  laser.inputs.assign(static_cast<std::size_t>(board.inputs_size()), false);
  options.sensor_window = std::chrono::nanoseconds(
      static_cast<std::int64_t>(1000 * board.sensor_window_us()));
  return options;
}

}  // namespace intaglio::reference_controller
