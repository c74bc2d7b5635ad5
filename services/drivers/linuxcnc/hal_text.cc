#include "services/drivers/linuxcnc/hal_text.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>

namespace intaglio::drivers {
namespace {

constexpr double kMaxNumber = 2251799813685248.0;  // 2^51

/// Fields between blanks.
class Fields {
 public:
  explicit Fields(std::string_view text) : rest_(text) {}
  std::string_view Next() {
    const auto begin = rest_.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return rest_ = {};
    rest_.remove_prefix(begin);
    const auto end = std::min(rest_.find_first_of(" \t\r"), rest_.size());
    const std::string_view field = rest_.substr(0, end);
    rest_.remove_prefix(end);
    return field;
  }
  template <typename Number>
  bool Take(Number& value) {
    const std::string_view field = Next();
    const auto [end, error] =
        std::from_chars(field.data(), field.data() + field.size(), value);
    return error == std::errc() && !field.empty() && end == field.data() + field.size();
  }
  /// A whole number that HAL has as a float.
  bool TakeWhole(std::uint64_t& value) {
    double number = 0;
    if (!Take(number) || !(number >= 0 && number < kMaxNumber)) return false;
    value = static_cast<std::uint64_t>(std::llround(number));
    return true;
  }
  bool TakePlace(Vec3& place) {
    for (int axis = 0; axis < 3; ++axis) {
      if (!Take(place[axis]) || !std::isfinite(place[axis])) return false;
    }
    return true;
  }
  bool at_end() { return Next().empty(); }

 private:
  std::string_view rest_;
};

}  // namespace

void AppendText(const HalRow& row, std::string& text) {
  // The number at both ends shows a row that was torn.
  fmt::format_to(std::back_inserter(text),
                 "{} {} {} {} {:d} {:d} {:.9f} {:.9f} {:.9f} {}\n", row.tick, row.number,
                 row.arm, row.motion, row.fire, row.gated, row.position_mm.x(),
                 row.position_mm.y(), row.position_mm.z(), row.number);
}

void AppendText(const HalCommand& command, std::string& text) {
  fmt::format_to(std::back_inserter(text),
                 "{} {} {} {:d} {:d} {:d} {:d} {:d} {:d} {:d} {} {}\n", command.number,
                 command.arm, command.motion, command.heartbeat, command.stop,
                 command.wake, command.laser_reset, command.motion_reset, command.shutter,
                 command.lamp, command.periods, command.number);
}

std::optional<HalSample> ParseSample(std::string_view line) {
  Fields fields(line);
  HalSample sample;
  std::int64_t period = 0, flags = 0, pulses = 0;
  std::array<std::int64_t, 3> openings{};
  const bool good =
      fields.Take(period) && fields.Take(sample.tick) && fields.TakeWhole(sample.row) &&
      fields.TakeWhole(sample.row_arm) && fields.TakeWhole(sample.command) &&
      fields.TakeWhole(sample.arm) && fields.TakeWhole(sample.motion) &&
      fields.Take(flags) && fields.TakePlace(sample.actual_mm) &&
      fields.TakePlace(sample.target_mm) && fields.Take(pulses) &&
      fields.Take(openings[0]) && fields.Take(openings[1]) && fields.Take(openings[2]) &&
      fields.TakeWhole(sample.periods) && fields.at_end();
  if (!good) return std::nullopt;
  sample.flags = static_cast<std::uint32_t>(flags);
  // Counters of 32 bits with a sign.
  sample.pulses = static_cast<std::uint32_t>(pulses);
  for (const std::int64_t count : openings)
    sample.openings += static_cast<std::uint32_t>(count);
  return sample;
}

Result<HalIdentity> ParseIdentity(std::string_view text) {
  HalIdentity identity;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    Fields fields(text.substr(0, end));
    const std::string_view name = fields.Next();
    if (name == "power_up") fields.Take(identity.power_up);
    if (name == "period_ns") fields.Take(identity.period_ns);
    if (name == "serial_number") identity.serial_number = fields.Next();
    if (name == "laser" && fields.Next() == "beam") identity.laser = HalLaser::kBeam;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  if (identity.power_up != 0 && identity.period_ns >= 50'000 &&
      identity.period_ns <= 10'000'000 && identity.serial_number.size() <= 64)
    return identity;
  return Fail(ErrorCode::kUnreadable,
              "the file `identity` in the folder of the machine's HAL is damaged: start "
              "the HAL again with deploy/linuxcnc/start");
}

std::vector<std::uint32_t> ParsePulses(std::string_view text) {
  std::vector<std::uint32_t> ticks;
  for (auto end = text.find('\n'); end != std::string_view::npos; end = text.find('\n')) {
    std::uint32_t tick = 0;
    Vec3 place_mm;
    Fields fields(text.substr(0, end));
    if (fields.Take(tick) && fields.TakePlace(place_mm)) ticks.push_back(tick);
    text.remove_prefix(end + 1);
  }
  return ticks;
}

}  // namespace intaglio::drivers
