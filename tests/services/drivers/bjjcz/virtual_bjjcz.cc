#include "tests/services/drivers/bjjcz/virtual_bjjcz.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace intaglio::bjjcz {
namespace {

constexpr std::size_t kCommand = 12, kPacket = 3072;

std::uint16_t Uint16At(const std::string& bytes, std::size_t at) {
  const auto byte = [&](std::size_t i) {
    return static_cast<unsigned>(static_cast<unsigned char>(bytes[i]));
  };
  return static_cast<std::uint16_t>(byte(at) | byte(at + 1) << 8);
}

double DelayOf(std::uint16_t amount, std::uint16_t sign) {
  return sign == 0 ? amount : -static_cast<double>(amount);
}

}  // namespace

void VirtualBjjcz::Write(const std::string& bytes) {
  if (!on_) return;
  in_ += bytes;
  while (in_.size() >= 2) {
    const bool is_packet = Uint16At(in_, 0) >= 0x8000;
    const std::size_t size = is_packet ? kPacket : kCommand;
    if (in_.size() < size) return;
    for (std::size_t at = 0; at < size; at += kCommand) {
      Numbers numbers;
      for (std::size_t i = 0; i < numbers.size(); ++i)
        numbers[i] = Uint16At(in_, at + 2 * i);
      if (is_packet)
        list_.push_back(numbers);
      else
        TakeCommand(numbers);
    }
    in_.erase(0, size);
  }
}

std::string VirtualBjjcz::Read() { return std::exchange(out_, {}); }

void VirtualBjjcz::Reopen() {
  in_.clear();
  out_.clear();
}

void VirtualBjjcz::SetInput(int input, bool high) {
  const auto bit = static_cast<std::uint16_t>(1U << input);
  inputs_ = static_cast<std::uint16_t>(high ? inputs_ | bit : inputs_ & ~bit);
}

void VirtualBjjcz::SwitchOff() {
  EndMotion();
  on_ = lit_ = enabled_ = oscillator_ = executes_ = false;
  outputs_ = 0;
  list_.clear();
  correction_.clear();
  axis_ = axis_to_ = 0;
  at_ = {32768, 32768};
  Reopen();
}

void VirtualBjjcz::SwitchOn() { on_ = true; }

std::uint16_t VirtualBjjcz::Status() const {
  const bool ready = list_.size() < options_.packets * 256;
  return static_cast<std::uint16_t>((executes_ ? 0x04 : 0) | (ready ? 0x20 : 0) |
                                    (axis_ != axis_to_ ? 0x40 : 0));
}

void VirtualBjjcz::Answer(std::array<std::uint16_t, 3> numbers) {
  for (const std::uint16_t number : {numbers[0], numbers[1], numbers[2], Status()}) {
    out_ += static_cast<char>(number & 0xFF);
    out_ += static_cast<char>(number >> 8);
  }
}

void VirtualBjjcz::TakeCommand(const Numbers& numbers) {
  switch (numbers[0]) {
    case 0x02:
    case 0x04:
      enabled_ = numbers[0] == 0x04;
      break;
    case 0x05:
      executes_ = true;
      ++lists_executed_;
      break;
    case 0x09:
      return Answer(options_.serial_number);
    case 0x10:
      if (numbers[3] == 0) correction_.clear();
      correction_.push_back({numbers[1], numbers[2]});
      return;  // not answered
    case 0x12:
      if (!executes_) list_.clear();
      break;
    case 0x1F:
      EndMotion();
      axis_to_ = axis_ = std::round(axis_);
      executes_ = false;
      list_.clear();
      break;
    case 0x21:
      outputs_ = numbers[1];
      break;
    case 0x25:
      return Answer({0, inputs_, 0});
    case 0x26:
      axis_speed_ = std::max<double>(1, numbers[2]);
      break;
    case 0x28:
      axis_to_ = 0;
      break;
    case 0x29: {
      const std::uint32_t number = numbers[1] | static_cast<std::uint32_t>(numbers[2])
                                                    << 16;
      const double amount = number & 0x7FFFFFFF;
      axis_to_ = (number & 0x80000000) != 0 ? -amount : amount;
      break;
    }
    case 0x2A: {
      const auto amount = static_cast<std::uint32_t>(std::abs(std::round(axis_)));
      const std::uint32_t number = amount | (axis_ < 0 ? 0x80000000 : 0);
      return Answer({0, static_cast<std::uint16_t>(number >> 16),
                     static_cast<std::uint16_t>(number & 0xFFFF)});
    }
    case 0x33:
      oscillator_ = numbers[1] == 1;
      break;
    default: {
      constexpr auto kKnown = std::to_array<std::uint16_t>(
          {0x06, 0x07, 0x0A, 0x0C, 0x15, 0x16, 0x17, 0x19, 0x1A, 0x1B, 0x1C,
           0x1D, 0x1E, 0x22, 0x27, 0x2E, 0x32, 0x39, 0x3A, 0x40, 0x41});
      if (std::ranges::find(kKnown, numbers[0]) == kKnown.end()) ++unknown_count_;
    }
  }
  Answer({0, 0, 0});
}

bool VirtualBjjcz::MayEmit() const {
  const bool interlocked =
      options_.interlock_input >= 0 && (inputs_ >> options_.interlock_input & 1) == 0;
  return !interlocked && enabled_ && (outputs_ >> options_.gate_output & 1) != 0 &&
         (oscillator_ || !options_.needs_oscillator);
}

void VirtualBjjcz::EndMotion() {
  if (moves_) {
    stroke_.end_us = now_us_;
    const double done = total_us_ > 0 ? 1 - left_us_ / total_us_ : 1;
    for (std::size_t i = 0; i < 2; ++i)
      stroke_.to[i] = stroke_.from[i] + done * (stroke_.to[i] - stroke_.from[i]);
    at_ = stroke_.to;
    strokes_.push_back(stroke_);
  }
  if (is_point_) flashes_.push_back(flash_);
  is_point_ = false;
  moves_ = waits_ = follows_mark_ = lit_ = false;
  left_us_ = settle_us_ = off_left_us_ = on_left_us_ = 0;
}

void VirtualBjjcz::BeginCommand(const Numbers& numbers) {
  const bool is_mark = numbers[0] == 0x8005;
  if (numbers[0] == 0x8001 || is_mark) {
    if (is_mark && !follows_mark_) on_left_us_ = on_delay_us_;
    if (!is_mark && std::exchange(follows_mark_, false)) off_left_us_ = off_delay_us_;
    stroke_ = laser_;
    stroke_.from = at_;
    stroke_.to = {static_cast<double>(numbers[1]), static_cast<double>(numbers[2])};
    stroke_.is_mark = is_mark;
    stroke_.outputs = outputs_;
    stroke_.begin_us = now_us_;
    const double way = std::hypot(stroke_.to[0] - at_[0], stroke_.to[1] - at_[1]);
    total_us_ = left_us_ = 1000 * way / (is_mark ? mark_speed_ : jump_speed_);
    settle_us_ = is_mark ? 0 : jump_delay_us_;
    moves_ = true;
    if (is_mark) follows_mark_ = true;
    return;
  }
  switch (numbers[0]) {
    case 0x8002:
      if (std::exchange(follows_mark_, false)) off_left_us_ = off_delay_us_;
      break;
    case 0x8003:
    case 0x8004:
      if (std::exchange(follows_mark_, false)) off_left_us_ = off_delay_us_;
      left_us_ = 10.0 * numbers[1];
      waits_ = true;
      is_point_ = numbers[0] == 0x8003;
      flash_ = {.at = at_,
                .axis = static_cast<std::int32_t>(std::lround(axis_)),
                .begin_us = now_us_,
                .current = laser_.current,
                .power_ratio = laser_.power_ratio};
      break;
    case 0x8006:
      jump_speed_ = std::max<double>(1, numbers[1]);
      break;
    case 0x8007:
      on_delay_us_ = std::max(0.0, DelayOf(numbers[1], numbers[2]));
      break;
    case 0x8008:
      off_delay_us_ = std::max(0.0, DelayOf(numbers[1], numbers[2]));
      break;
    case 0x800A:
      laser_.mark_period = numbers[1];
      break;
    case 0x800B:
      laser_.power_ratio = numbers[1];
      break;
    case 0x800C:
      mark_speed_ = std::max<double>(1, numbers[1]);
      break;
    case 0x800D:
      jump_delay_us_ = numbers[1];
      break;
    case 0x800F:
      polygon_delay_us_ = numbers[1];
      break;
    case 0x8012:
      laser_.current = numbers[1];
      break;
    case 0x801B:
      laser_.q_switch_period = numbers[1];
      break;
    case 0x8011:
    case 0x801E:
    case 0x8026:
    case 0x8051:
      break;
    default:
      ++unknown_count_;
  }
}

int VirtualBjjcz::PulsesIn(double lit_us) const {
  // A fibre source counts its period at 20 MHz, the others at 10 MHz.
  const double period_us =
      laser_.mark_period > 0 ? laser_.mark_period / 10.0 : laser_.q_switch_period / 20.0;
  return period_us > 0 ? static_cast<int>(std::lround(lit_us / period_us)) : 0;
}

bool VirtualBjjcz::Step(double& left_us) {
  constexpr double kMaxStep_us = 50;
  if (!moves_ && !waits_ && settle_us_ <= 0) {
    // Behind the last command the beam ends as its delay has it.
    if (list_.empty() && std::exchange(follows_mark_, false))
      off_left_us_ = off_delay_us_;
    if (list_.empty() && off_left_us_ <= 0) {
      executes_ = lit_ = false;
      return false;
    }
    if (!list_.empty()) {
      BeginCommand(list_.front());
      list_.pop_front();
      if (!moves_ && !waits_) return true;
    }
  }
  // To the next instant at which anything changes.
  double step = std::min(left_us, kMaxStep_us);
  for (const double next_us :
       {moves_ || waits_ ? left_us_ : 0, moves_ || waits_ ? 0 : settle_us_, off_left_us_,
        moves_ && stroke_.is_mark ? on_left_us_ : 0})
    if (next_us > 0) step = std::min(step, next_us);
  const bool of_mark = moves_ && stroke_.is_mark;
  lit_ = MayEmit() &&
         ((of_mark && on_left_us_ <= 0) || off_left_us_ > 0 || (waits_ && is_point_));
  if (of_mark && on_left_us_ > 0) on_left_us_ -= step;
  if (off_left_us_ > 0) off_left_us_ -= step;
  now_us_ += step;
  left_us -= step;
  if (lit_) {
    ++work_count_;
    if (moves_) stroke_.lit_us += step;
    if (is_point_) flash_.lit_us += step;
  }
  if (moves_ || waits_) {
    left_us_ -= step;
    if (moves_ && step > 0) ++work_count_;
    if (left_us_ <= 1e-9) {
      left_us_ = 0;
      if (moves_) {
        stroke_.end_us = now_us_;
        at_ = stroke_.to;
        strokes_.push_back(stroke_);
      }
      if (std::exchange(is_point_, false)) {
        flash_.pulses = PulsesIn(flash_.lit_us);
        flashes_.push_back(flash_);
      }
      moves_ = waits_ = false;
    }
  } else if (settle_us_ > 0) {
    settle_us_ -= step;
  }
  return true;
}

std::array<double, 2> VirtualBjjcz::place() const {
  if (!moves_ || total_us_ <= 0) return at_;
  const double done = 1 - left_us_ / total_us_;
  return {stroke_.from[0] + done * (stroke_.to[0] - stroke_.from[0]),
          stroke_.from[1] + done * (stroke_.to[1] - stroke_.from[1])};
}

// At its speed, without a ramp.
void VirtualBjjcz::AdvanceAxis(double us) {
  const double way = axis_speed_ * us / 1e6, left = axis_to_ - axis_;
  axis_ = std::abs(left) <= way ? axis_to_ : axis_ + std::copysign(way, left);
}

void VirtualBjjcz::Advance(double us) {
  if (on_) AdvanceAxis(us);
  double left_us = us;
  while (left_us > 1e-9 && on_ && executes_ && Step(left_us)) {
  }
  now_us_ += std::max(0.0, left_us);
  if (!executes_) lit_ = false;
}

}  // namespace intaglio::bjjcz
