#include "tests/services/drivers/isel/virtual_isel.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

namespace intaglio::isel {
namespace {

constexpr double kBitsPerByte = 10;
constexpr char kDone = '0', kLimit = '2', kSyntax = '5', kCount = '7', kSystem = '9';
constexpr char kSpeed = 'D', kStopped = 'F', kCover = 'H', kNoReference = 'R';
constexpr auto kStopByte = static_cast<char>(253), kResetByte = static_cast<char>(254),
               kBreakByte = static_cast<char>(255);

/// Whole numbers with commas between; nothing for any other text.
std::optional<std::vector<std::int32_t>> NumbersOf(std::string_view text) {
  std::vector<std::int32_t> all;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(','), text.size());
    std::int32_t number = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + end, number);
    if (error != std::errc() || stop != text.data() + end) return std::nullopt;
    all.push_back(number);
    if (end + 1 == text.size()) return std::nullopt;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return all;
}

}  // namespace

VirtualIsel::VirtualIsel(VirtualIselOptions options) : options_(options) {}

void VirtualIsel::Write(std::string_view bytes) {
  for (const char byte : bytes) {
    arrives_at_us_ =
        std::max(arrives_at_us_, now_us_) + kBitsPerByte * 1e6 / options_.baud;
    to_controller_.push_back({arrives_at_us_, byte});
  }
}

std::string VirtualIsel::Read() {
  std::string text;
  for (; !to_host_.empty() && to_host_.front().at_us <= now_us_; to_host_.pop_front())
    text += to_host_.front().value;
  return text;
}

void VirtualIsel::Answer(const std::string& text) {
  for (const char byte : text) {
    sent_at_us_ = std::max(sent_at_us_, now_us_) + kBitsPerByte * 1e6 / options_.baud;
    to_host_.push_back({sent_at_us_, byte});
  }
}

void VirtualIsel::Advance(double us) {
  constexpr double kStepUs = 50;
  for (const double end = now_us_ + us; now_us_ < end;) {
    now_us_ = std::min(end, now_us_ + kStepUs);
    while (!to_controller_.empty() && to_controller_.front().at_us <= now_us_) {
      const char byte = to_controller_.front().value;
      to_controller_.pop_front();  // a reset clears what follows
      Receive(byte);
    }
    if (moving_) AdvanceMove();
    const auto line = receive_buffer_.find('\r');
    if (moving_ || line == std::string::npos || now_us_ < ready_at_us_) continue;
    const std::string command = receive_buffer_.substr(0, line);
    receive_buffer_.erase(0, line + 1);
    Obey(command);
    ready_at_us_ = now_us_ + options_.command_us;
  }
}

void VirtualIsel::Receive(char byte) {
  if (byte == kStopByte || byte == kBreakByte) return StopMove(kStopped);
  if (byte == kResetByte) return PowerCycle();
  if (receive_buffer_.find('\r') == std::string::npos)
    ready_at_us_ = std::max(ready_at_us_, now_us_ + options_.command_us);
  receive_buffer_ += byte;
}

void VirtualIsel::Obey(const std::string& command) {
  const auto starts = [&](std::string_view with) { return command.starts_with(with); };
  const std::string rest = command.size() > 3 ? command.substr(3) : "";
  if (command == "@07" || command == "@08") {
    axes_ = command == "@07" ? 3 : 4;
    return Answer({kDone});
  }
  if (!starts("@0") || command.size() < 3) return Answer({kSyntax});
  if (axes_ == 0) return Answer({kSystem});
  char answer = kSyntax;
  if (command == "@0R7") answer = BeginHome();
  if (command == "@0n7") {
    zero_ = place_;
    answer = kDone;
  }
  if (starts("@0M")) answer = BeginMove(rest, false);
  if (starts("@0A")) answer = BeginMove(rest, true);
  if (starts("@0B")) answer = SetOutput(rest);
  if (command == "@0F") answer = kDone;
  if (starts("@0J") || starts("@0j")) answer = NumbersOf(rest) ? kDone : kSyntax;
  if (command == "@0P") return Answer(kDone + Position());
  if (!moving_) Answer({answer});  // else when the move has ended
}

std::string VirtualIsel::Position() const {
  std::string text;
  for (std::size_t i = 0; i < 3; ++i)
    text += fmt::format("{:06X}",
                        static_cast<std::uint32_t>(place_[i] - zero_[i]) & 0xffffffu);
  return axes_ == 4 ? text + "000000" : text;
}

char VirtualIsel::BeginMove(const std::string& numbers, bool relative) {
  const auto given = NumbersOf(numbers);
  if (!given) return kSyntax;
  if (given->size() != 8) return kCount;
  if (cover_open_) return kCover;
  if (!referenced_) return kNoReference;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int32_t speed = (*given)[2 * i + 1];
    if (speed < options_.min_speed || speed > options_.max_speed) return kSpeed;
    target_[i] = (*given)[2 * i] + (relative ? place_[i] : zero_[i]);
    speed_[i] = speed;
  }
  from_ = place_;
  began_us_ = now_us_;
  moving_ = true;
  return kDone;
}

char VirtualIsel::BeginHome() {
  if (cover_open_) return kCover;
  from_ = place_;
  target_ = zero_ = {0, 0, 0};
  speed_.fill(options_.home_speed);
  began_us_ = now_us_;
  moving_ = homing_ = true;
  return kDone;
}

char VirtualIsel::SetOutput(const std::string& numbers) {
  const auto given = NumbersOf(numbers);
  if (!given) return kSyntax;
  if (given->size() != 2) return kCount;
  const bool on = (*given)[1] != 0;
  if (on && cover_open_) return kCover;
  if ((*given)[0] != 1) return kDone;
  if (on && !output_) flashes_.push_back({place_, now_us_, 0, moving_});
  if (!on && output_) flashes_.back().off_us = now_us_;
  output_ = on;
  return kDone;
}

void VirtualIsel::AdvanceMove() {
  if (output_) flashes_.back().moved = true;
  bool there = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const double way = std::floor((now_us_ - began_us_) * 1e-6 * speed_[i]);
    const std::int32_t whole = std::abs(target_[i] - from_[i]);
    const auto done = static_cast<std::int32_t>(std::min<double>(way, whole));
    place_[i] = from_[i] + (target_[i] < from_[i] ? -done : done);
    there = there && done == whole;
    if (homing_) continue;
    if (place_[i] < options_.travel_min[i] || place_[i] > options_.travel_max[i]) {
      place_[i] = std::clamp(place_[i], options_.travel_min[i], options_.travel_max[i]);
      referenced_ = false;
      return EndMove(kLimit);
    }
  }
  if (!there) return;
  referenced_ = referenced_ || homing_;
  EndMove(kDone);
}

void VirtualIsel::EndMove(char answer) {
  moving_ = homing_ = false;
  ready_at_us_ = now_us_ + options_.command_us;
  Answer({answer});
}

void VirtualIsel::StopMove(char answer) {
  if (moving_) EndMove(answer);
}

void VirtualIsel::SetCover(bool open) {
  cover_open_ = open;
  if (open) StopMove(kCover);
}

void VirtualIsel::HomeAtPanel() {
  place_ = zero_ = {};
  referenced_ = true;
}

void VirtualIsel::PowerCycle() {
  if (output_) flashes_.back().off_us = now_us_;
  moving_ = homing_ = output_ = referenced_ = false;
  axes_ = 0;
  zero_ = place_;
  receive_buffer_.clear();
  to_controller_.clear();
  to_host_.clear();
}

}  // namespace intaglio::isel
