#include "services/virtual_engraver/mill/virtual_grbl.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

namespace intaglio::grbl {
namespace {

constexpr double kSlice_us = 50;
constexpr std::size_t kMaxLine = 79;
constexpr double kBitsPerByte = 10;
constexpr int kUnknownCommand = 20;
constexpr int kReportsPerOffset = 10;
constexpr int kAbortInMotion = 3, kEmergencyStop = 10;

}  // namespace

VirtualGrblOptions Grbl11() { return {}; }

VirtualGrblOptions GrblHal() {
  VirtualGrblOptions options;
  options.hal = true;
  options.receive_bytes = 1023;
  options.parse_us = 400;
  options.parse_us_per_byte = 75;
  options.motion.planner_blocks = 100;
  return options;
}

VirtualGrbl::VirtualGrbl(VirtualGrblOptions options)
    : options_(std::move(options)),
      motion_(options_.motion),
      byte_us_(kBitsPerByte * 1e6 / options_.baud),
      locked_(options_.homing) {
  Banner();
  UpdateState();
}

void VirtualGrbl::Write(std::string_view bytes) {
  for (const char byte : bytes) {
    const double free = to_grbl_.empty() ? now_us_ : to_grbl_.back().at_us;
    to_grbl_.push_back({byte, std::max(now_us_, free) + byte_us_});
  }
}

void VirtualGrbl::Send(std::string_view text) {
  for (const char byte : text) {
    const double free = to_host_.empty() ? now_us_ : to_host_.back().at_us;
    to_host_.push_back({byte, std::max(now_us_, free) + byte_us_});
  }
}

std::string VirtualGrbl::Read() {
  std::string read;
  while (!to_host_.empty() && to_host_.front().at_us <= now_us_) {
    read += to_host_.front().byte;
    to_host_.pop_front();
  }
  return read;
}

void VirtualGrbl::Banner() { Send("\r\nGrbl 1.1h ['$' for help]\r\n"); }

void VirtualGrbl::Answer(int error) {
  if (error < 0) return;
  if (error == 0) return Send("ok\r\n");
  Send(fmt::format("error:{}\r\n", error));
}

void VirtualGrbl::Advance(double us) {
  while (us > 0) {
    const double part = std::min(us, kSlice_us);
    Slice(part);
    us -= part;
  }
}

void VirtualGrbl::Slice(double us) {
  motion_.Advance(us);
  now_us_ += us;
  ReceiveBytes();
  if (crashed_ || off_) return;
  // Mute: bytes wait in the buffer, a '?' is answered when it has ended.
  if (state_ == State::kHome) return AdvanceHome(us);
  UpdateState();
  if (waiting_ && !suspended()) FinishWaiting(us);
  UpdateState();
  if (!suspended()) TakeLines();
  if (reports_ && !mute_) Report();
  reports_ = false;
}

void VirtualGrbl::ReceiveBytes() {
  while (!to_grbl_.empty() && to_grbl_.front().at_us <= now_us_) {
    const char byte = to_grbl_.front().byte;
    to_grbl_.pop_front();
    if (!crashed_ && !off_) TakeByte(byte);
  }
}

void VirtualGrbl::TakeByte(char byte) {
  if (TakeRealtime(static_cast<unsigned char>(byte))) return;
  if (receive_buffer_.size() >= options_.receive_bytes) {
    ++lost_bytes_;
    return;
  }
  receive_buffer_.push_back(byte);
}

bool VirtualGrbl::TakeRealtime(unsigned char byte) {
  if (byte == 0x18) {
    ++resets_taken_;
    if (state_ == State::kHome) return EndHome(6), true;
    Reset();
  } else if (byte == '?') {
    reports_ = true;
  } else if (byte == '!') {
    if (state_ == State::kRun || state_ == State::kIdle) {
      motion_.Hold();
      state_ = State::kHold;
    } else if (state_ == State::kJog) {
      motion_.CancelJog();
    }
  } else if (byte == '~') {
    const bool door_holds = state_ == State::kDoor && door_open_;
    if (suspended() && !door_holds && !motion_.moving()) {
      motion_.Resume();
      motion_.ForceDark(false);
      state_ = State::kIdle;
    }
  } else if (byte == 0x85) {
    if (state_ == State::kJog) motion_.CancelJog();
  } else {
    return byte >= 0x80;
  }
  return true;
}

void VirtualGrbl::TakeLines() {
  while (!waiting_ && !mute_ && !suspended() && !crashed_ && state_ != State::kHome) {
    if (parsing_) {
      if (now_us_ < parses_until_us_) return;
      const std::string line = std::move(*parsing_);
      parsing_.reset();
      if (takes_before_refusal_ && (*takes_before_refusal_)-- == 0) {
        takes_before_refusal_.reset();
        Answer(kUnknownCommand);
      } else {
        Execute(line);
      }
      UpdateState();
      continue;
    }
    if (receive_buffer_.empty()) return;
    const char byte = receive_buffer_.front();
    receive_buffer_.pop_front();
    if (byte == '\n' || byte == '\r') {
      if (line_.empty() && byte == '\n') continue;
      parses_until_us_ =
          now_us_ + options_.parse_us +
          options_.parse_us_per_byte * static_cast<double>(line_.size() + 1);
      parsing_ = std::exchange(line_, {});
    } else if (byte > ' ' && line_.size() <= kMaxLine) {
      line_ += static_cast<char>(std::toupper(byte));
    }
  }
}

void VirtualGrbl::FinishWaiting(double us) {
  Waiting& wait = *waiting_;
  if (wait.reason == Waiting::For::kRoom) {
    if (motion_.is_full()) return;
    motion_.Add(wait.target, wait.speed_mm_s, wait.beam, wait.jog, wait.line, wait.power);
    if (!wait.later.empty()) {
      wait.target = wait.later.front();
      wait.later.pop_front();
      return;
    }
    if (wait.jog) state_ = State::kJog;
  } else if (wait.reason == Waiting::For::kEmpty) {
    if (!motion_.is_empty()) return;
    if (wait.spindle) CommandSpindle(*wait.spindle);
    if (wait.sets_offset) work_offset_mm_ = wait.offset_mm;
    if (wait.sets_offset) reports_to_offset_ = 0;
    if (wait.dwell_us > 0) {
      wait.reason = Waiting::For::kDwell;
      return;
    }
  } else if ((wait.dwell_us -= us) > 0) {
    return;
  }
  waiting_.reset();
  Answer(0);
}

void VirtualGrbl::CommandSpindle(Spindle spindle) {
  spindle_ = spindle;
  // In laser mode M4 is off until something moves, and G0 is dark.
  const bool in_g1 = !rapid_ || !options_.laser_mode;
  const bool rests_lit = spindle == Spindle::kConstant ||
                         (spindle == Spindle::kDynamic && !options_.laser_mode);
  motion_.SetRestingBeam(rests_lit && power_ > 0 && in_g1);
}

void VirtualGrbl::UpdateState() {
  if (state_ == State::kHome) return;
  if (state_ == State::kAlarm && locked_) return;
  if (locked_) {
    state_ = State::kAlarm;
    return;
  }
  if (suspended()) {
    // A spindle turns on in a hold; a door ends it.
    const bool goes_on = state_ == State::kHold && !options_.laser_mode;
    if (!motion_.moving() && !goes_on) motion_.ForceDark(true);
    return;
  }
  if (state_ == State::kJog && !motion_.is_empty()) return;
  state_ = motion_.is_empty() ? State::kIdle : State::kRun;
}

void VirtualGrbl::SetDoor(bool open) {
  door_open_ = open;
  if (!open || state_ == State::kAlarm) return;
  if (state_ == State::kHome) return EndHome(7);
  if (state_ == State::kJog) {
    motion_.CancelJog();
  } else {
    motion_.Hold();
  }
  state_ = State::kDoor;
}

void VirtualGrbl::BeginHome() {
  state_ = State::kHome;
  home_from_ = motion_.at();
  home_done_us_ = home_us_ = 0;
  const Steps from = TrueSteps();
  for (std::size_t i = 0; i < 3; ++i) {
    home_way_[i] = options_.home_steps[i] - from[i];
    const double way_mm = std::abs(double(home_way_[i])) / options_.motion.steps_per_mm;
    home_us_ = std::max(home_us_, way_mm / options_.home_mm_s * 1e6);
  }
}

void VirtualGrbl::AdvanceHome(double us) {
  home_done_us_ = std::min(home_us_, home_done_us_ + us);
  const double part = home_us_ > 0 ? home_done_us_ / home_us_ : 1;
  Steps at{};
  for (std::size_t i = 0; i < 3; ++i)
    at[i] = home_from_[i] + std::llround(static_cast<double>(home_way_[i]) * part);
  motion_.MoveTo(at);
  if (part < 1) return;
  motion_.CountAs({});
  homed_ = true;
  locked_ = false;
  state_ = State::kIdle;
  Answer(0);
}

void VirtualGrbl::EndHome(int alarm) {
  homed_ = false;
  RaiseAlarm(alarm);
  Reset();
}

void VirtualGrbl::HitLimit() {
  motion_.Kill();
  RaiseAlarm(1);
  mute_ = true;
}

void VirtualGrbl::PressReset() {
  if (off_) return;
  if (state_ == State::kHome) return EndHome(6);
  Reset();
}

void VirtualGrbl::SetEmergencyStop(bool pressed) {
  emergency_stop_ = pressed;
  if (!pressed || off_) return;
  Reset();
}

void VirtualGrbl::FailDrive() {
  motion_.Kill();
  spindle_ = Spindle::kOff;
  RaiseAlarm(kAbortInMotion);
}

void VirtualGrbl::SwitchOff() {
  motion_.Kill();
  spindle_ = Spindle::kOff;
  off_ = true;
  to_grbl_.clear();
  to_host_.clear();
}

void VirtualGrbl::RaiseAlarm(int code) {
  locked_ = true;
  state_ = State::kAlarm;
  Send(fmt::format("ALARM:{}\r\n", code));
  if (code != 2) return;
  motion_.Kill();
  spindle_ = Spindle::kOff;
}

void VirtualGrbl::Reset() {
  const bool in_motion = motion_.moving() || (!suspended() && !motion_.is_empty());
  motion_.Kill();
  motion_.ForceDark(false);
  motion_.SetRestingBeam(false);
  waiting_.reset();
  parsing_.reset();
  receive_buffer_.clear();
  line_.clear();
  spindle_ = Spindle::kOff;
  power_ = feed_mm_min_ = 0;
  absolute_ = rapid_ = true;
  mute_ = false;
  if (in_motion) RaiseAlarm(kAbortInMotion);
  if (emergency_stop_) RaiseAlarm(kEmergencyStop);
  state_ = locked_ ? State::kAlarm : State::kIdle;
  if (!locked_ && door_open_) state_ = State::kDoor;
  Banner();
  if (locked_) Send("[MSG:'$H'|'$X' to unlock]\r\n");
}

void VirtualGrbl::PowerCycle() {
  motion_.Kill();
  motion_.ForceDark(false);
  motion_.CountAs({});
  waiting_.reset();
  parsing_.reset();
  to_grbl_.clear();
  to_host_.clear();
  receive_buffer_.clear();
  line_.clear();
  spindle_ = Spindle::kOff;
  power_ = feed_mm_min_ = 0;
  absolute_ = rapid_ = true;
  mute_ = crashed_ = homed_ = output_on_ = off_ = false;
  takes_before_refusal_.reset();
  reports_to_offset_ = 0;
  locked_ = options_.homing || emergency_stop_;
  state_ = State::kIdle;
  UpdateState();
  Banner();
}

const char* VirtualGrbl::StateName() const {
  switch (state_) {
    case State::kIdle:
      return "Idle";
    case State::kRun:
      return "Run";
    case State::kHold:
      return motion_.moving() ? "Hold:1" : "Hold:0";
    case State::kJog:
      return "Jog";
    case State::kDoor:
      return door_open_ ? (motion_.moving() ? "Door:2" : "Door:1") : "Door:0";
    case State::kAlarm:
      return "Alarm";
    case State::kHome:
      return "Home";
  }
  return "";
}

void VirtualGrbl::Report() {
  const Vec3 at = WorkPosition_mm();
  std::string text = fmt::format("<{}|WPos:{:.3f},{:.3f},{:.3f}|Bf:{},{}", StateName(),
                                 at.x(), at.y(), at.z(), motion_.free_blocks(),
                                 options_.receive_bytes - receive_buffer_.size());
  if (options_.reports_lines && motion_.line() > 0) {
    text += fmt::format("|Ln:{}", motion_.line());
  }
  text += fmt::format("|FS:{:.0f},{:.0f}", motion_.speed_mm_s() * 60, power_);
  const std::string pins = std::string(door_open_ ? "D" : "") + stop_pin();
  if (!pins.empty()) text += "|Pn:" + pins;
  if (--reports_to_offset_ <= 0) {
    reports_to_offset_ = kReportsPerOffset;
    text += fmt::format("|WCO:{:.3f},{:.3f},{:.3f}", work_offset_mm_.x(),
                        work_offset_mm_.y(), work_offset_mm_.z());
  }
  Send(text + ">\r\n");
}

}  // namespace intaglio::grbl
