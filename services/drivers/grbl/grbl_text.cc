#include "services/drivers/grbl/grbl_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

namespace intaglio::drivers {
namespace {

// No machine is larger; a number beyond it is a damaged line.
constexpr double kMaxPlace_mm = 1e6;

bool StartsWith(std::string_view text, std::string_view start) {
  return text.substr(0, start.size()) == start;
}

template <typename Number>
std::optional<Number> NumberOf(std::string_view text) {
  Number value{};
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || last != end) return std::nullopt;
  return value;
}

std::vector<std::string_view> Split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

// Controllers with more axes report them behind the first three.
std::optional<Vec3> PlaceOf(std::string_view text) {
  const auto parts = Split(text, ',');
  if (parts.size() < 3) return std::nullopt;
  Vec3 place;
  for (int i = 0; i < 3; ++i) {
    const auto value = NumberOf<double>(parts[i]);
    if (!value || !(std::abs(*value) <= kMaxPlace_mm)) return std::nullopt;
    place[i] = *value;
  }
  return place;
}

GrblState StateOf(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, GrblState>, 7> kStates = {{
      {"Idle", GrblState::kIdle},
      {"Run", GrblState::kRun},
      {"Hold", GrblState::kHold},
      {"Jog", GrblState::kJog},
      {"Door", GrblState::kDoor},
      {"Alarm", GrblState::kAlarm},
      {"Home", GrblState::kHome},
  }};
  for (const auto& [known, state] : kStates) {
    if (name == known) return state;
  }
  return GrblState::kOther;
}

// False: the status is damaged.
bool TakeField(std::string_view field, GrblStatus& status) {
  const std::size_t colon = field.find(':');
  if (colon == std::string_view::npos) return true;
  const std::string_view name = field.substr(0, colon), value = field.substr(colon + 1);
  if (name == "WPos") return (status.work_mm = PlaceOf(value)).has_value();
  if (name == "MPos") return (status.machine_mm = PlaceOf(value)).has_value();
  if (name == "WCO") return (status.work_offset_mm = PlaceOf(value)).has_value();
  if (name == "Pn") status.pins = value;
  const auto parts = Split(value, ',');
  const auto first = NumberOf<double>(parts[0]);
  const bool whole = first && *first >= 0 && *first <= 1e9;
  if (name == "Bf") {
    const auto bytes = parts.size() > 1 ? NumberOf<int>(parts[1]) : std::nullopt;
    if (!whole || !bytes) return false;
    status.free_blocks = static_cast<int>(*first);
    status.free_bytes = *bytes;
  } else if (name == "Ln") {
    if (!whole) return false;
    status.line = static_cast<std::int64_t>(*first);
  } else if (name == "FS" || name == "F") {
    if (!first) return false;
    status.feed_mm_min = *first;
  }
  return true;
}

GrblAnswer StatusOf(std::string_view text) {
  const auto fields = Split(text, '|');
  GrblStatus status;
  const auto state = Split(fields[0], ':');
  status.state = StateOf(state[0]);
  if (state.size() > 1) status.substate = NumberOf<int>(state[1]).value_or(-1);
  for (std::size_t i = 1; i < fields.size(); ++i) {
    if (!TakeField(fields[i], status)) return GrblOther{};
  }
  if (!status.work_mm && !status.machine_mm) return GrblOther{};
  return status;
}

GrblAnswer ModesOf(std::string_view text) {
  bool rapid = false, feeds = true;
  for (const std::string_view word : Split(text, ' ')) {
    if (word == "G0") rapid = true;
    if (StartsWith(word, "F")) feeds = NumberOf<double>(word.substr(1)) != 0.0;
  }
  return GrblModes{rapid && !feeds};
}

GrblAnswer BracketOf(std::string_view text) {
  if (StartsWith(text, "GC:")) return ModesOf(text.substr(3));
  if (StartsWith(text, "VER:")) {
    const auto parts = Split(text.substr(4), ':');
    return GrblVersion{std::string(parts[0]),
                       std::string(parts.size() > 1 ? parts[1] : "")};
  }
  if (!StartsWith(text, "OPT:")) return GrblOther{};
  const auto parts = Split(text.substr(4), ',');
  GrblBuild build{std::string(parts[0])};
  if (parts.size() > 1) build.planner_blocks = NumberOf<int>(parts[1]).value_or(0);
  if (parts.size() > 2) build.receive_bytes = NumberOf<int>(parts[2]).value_or(0);
  return build;
}

GrblAnswer SettingOf(std::string_view text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) return GrblOther{};
  const auto number = NumberOf<int>(text.substr(0, equals));
  // grblHAL adds descriptions to some.
  const auto value = NumberOf<double>(Split(text.substr(equals + 1), ' ')[0]);
  if (!number || !value || !std::isfinite(*value)) return GrblOther{};
  return GrblSetting{*number, *value};
}

}  // namespace

GrblAnswer ParseGrblAnswer(std::string_view line) {
  if (line == "ok") return GrblOk{};
  if (StartsWith(line, "error:")) {
    if (const auto code = NumberOf<int>(line.substr(6))) return GrblError{*code};
    return GrblError{};
  }
  if (StartsWith(line, "ALARM:")) {
    if (const auto code = NumberOf<int>(line.substr(6))) return GrblAlarm{*code};
    return GrblAlarm{};
  }
  if (StartsWith(line, "Grbl ") || StartsWith(line, "GrblHAL ")) return GrblBanner{};
  if (line.size() < 2) return GrblOther{};
  const std::string_view inner = line.substr(1, line.size() - 2);
  if (line.front() == '<' && line.back() == '>') return StatusOf(inner);
  if (line.front() == '[' && line.back() == ']') return BracketOf(inner);
  if (line.front() == '$') return SettingOf(line.substr(1));
  return GrblOther{};
}

std::string TextOfGrblError(int code) {
  constexpr std::array<std::pair<int, const char*>, 12> kTexts = {{
      {1, "a line without a letter"},
      {2, "a number that cannot be read"},
      {5, "homing is not enabled ($22)"},
      {8, "a '$' command while it is not idle"},
      {9, "it is locked by an alarm or a jog"},
      {11, "a line that is too long"},
      {13, "the safety door is open: close it"},
      {15, "a jog beyond the travel"},
      {20, "a command that it does not know"},
      {22, "no feed rate"},
      {24, "two commands in one line"},
      {50, "the emergency stop is pressed: release it"},
  }};
  for (const auto& [known, text] : kTexts) {
    if (known == code) return fmt::format("error:{} ({})", code, text);
  }
  return fmt::format("error:{}", code);
}

std::string TextOfGrblAlarm(int code) {
  constexpr std::array<std::pair<int, const char*>, 8> kTexts = {{
      {1, "a limit switch was hit: free the axis and home"},
      {2, "a target beyond the travel ($130-$132): check block_origin_mm and the zero"},
      {3, "reset while moving: steps may be lost, check the zero"},
      {6, "homing was ended by a reset: home again"},
      {7, "homing was ended by the safety door: close it and home again"},
      {8, "homing failed: a switch was not released"},
      {9, "homing failed: a switch was not found"},
      {10, "the emergency stop is pressed"},
  }};
  for (const auto& [known, text] : kTexts) {
    if (known == code) return fmt::format("ALARM:{} ({})", code, text);
  }
  return fmt::format("ALARM:{}", code);
}

void GrblAnswerReader::Feed(std::span<const std::byte> bytes,
                            std::vector<std::string>& lines) {
  for (const std::byte byte : bytes) {
    const char c = static_cast<char>(byte);
    if (c != '\n' && c != '\r') {
      overlong_ = overlong_ || line_.size() >= kMaxLine;
      if (!overlong_) line_ += c;
      continue;
    }
    if (!overlong_ && !line_.empty()) lines.push_back(line_);
    Clear();
  }
}

std::string ZeroLine(const Vec3& here_mm, const std::array<bool, 3>& sets) {
  std::string text = "G10L20P1";
  for (int i = 0; i < 3; ++i) {
    if (sets[static_cast<std::size_t>(i)])
      text += fmt::format("{}{:.4f}", "XYZ"[i], here_mm[i]);
  }
  return text;
}

std::string WhyGrblIsNotSetUp(int code) {
  return "the controller refused a line of its set-up: " + TextOfGrblError(code) +
         "; check its version, then resume";
}

std::string WhyGrblPlaceIsLost(const std::string& remedy) {
  return "the controller may not know where its tool is, because it was switched on, "
         "reset or stopped by an alarm: " +
         remedy;
}

}  // namespace intaglio::drivers
