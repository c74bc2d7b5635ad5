#include "services/drivers/grbl/grbl_line.h"

#include <fmt/format.h>

#include <array>
#include <span>
#include <utility>

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

constexpr auto kGrblSilence = 250ms;
constexpr auto kQuestionPeriod = 20ms;
constexpr auto kStepTimeout = 2s;
constexpr auto kHomeTimeout = 300s;
// A step of a coarse controller, and the decimals of its status.
constexpr double kPlaceTolerance_mm = 0.02;
constexpr double kAtZero_mm = 0.0005;  // decimals of a status
// The emergency stop's input of grblHAL, and the reset's.
constexpr const char* kStopPins = "ER";

bool IsWithin(const Box3& box, const Vec3& place) {
  return (place.array() >= box.min_mm.array() - kPlaceTolerance_mm).all() &&
         (place.array() <= box.max_mm.array() + kPlaceTolerance_mm).all();
}

}  // namespace

GrblLine::GrblLine(link::StreamOpener open, link::SteadyClock clock,
                   link::ExpectedDevice expected, GrblTool tool)
    : ControllerLine(std::move(open), std::move(clock)),
      expected_(std::move(expected)),
      tool_(tool) {}

void GrblLine::Poll(std::vector<Event>& events) {
  if (!stream_) Open();
  if (!stream_) return;
  Read(events);
  if (!stream_) return;
  CheckSilence(events);
  Ask();
  Write();
}

void GrblLine::Open() {
  if (!OpenStream()) return;
  phase_ = Phase::kAsking;
  reader_.Clear();
  asked_at_.reset();
  phase_at_ = now();
  next_status_ = {};
}

void GrblLine::Read(std::vector<Event>& events) {
  std::array<std::byte, 1024> buffer;
  std::vector<std::string> lines;
  for (;;) {
    const auto count = stream_->Read(buffer);
    if (!count) {
      Lose(count.error().message, events);
      stream_.reset();
      phase_ = Phase::kClosed;
      return;
    }
    if (*count == 0) break;
    reader_.Feed(std::span(buffer).first(*count), lines);
  }
  for (const std::string& line : lines) Receive(ParseGrblAnswer(line), events);
}

void GrblLine::Receive(const GrblAnswer& answer, std::vector<Event>& events) {
  if (std::holds_alternative<GrblOther>(answer)) return;
  asked_at_.reset();
  if (std::holds_alternative<GrblBanner>(answer)) return TakeBanner(events);
  if (const auto* status = std::get_if<GrblStatus>(&answer)) {
    return TakeStatus(*status, events);
  }
  if (std::holds_alternative<GrblOk>(answer)) {
    return TakeAcknowledgement(true, 0, events);
  }
  if (const auto* error = std::get_if<GrblError>(&answer)) {
    return TakeAcknowledgement(false, error->code, events);
  }
  if (const auto* alarm = std::get_if<GrblAlarm>(&answer)) {
    alarm_ = true;
    LosePlace();
    if (!up()) return;
    set_up_ = false;
    home_failed_ = std::exchange(homing_, false);
    events.emplace_back(*alarm);
    // Limits leave it mute until a reset, which moves and lights nothing.
    if (alarm->code == 1 || alarm->code == 2) Reset();
  } else if (const auto* version = std::get_if<GrblVersion>(&answer)) {
    traits_.version = version->version;
    traits_.serial_number = version->serial_number;
  } else if (const auto* build = std::get_if<GrblBuild>(&answer)) {
    if (build->planner_blocks > 0) traits_.planner_blocks = build->planner_blocks;
    if (build->receive_bytes > 0) traits_.receive_bytes = build->receive_bytes;
  } else if (const auto* setting = std::get_if<GrblSetting>(&answer)) {
    TakeSetting(*setting);
  } else if (const auto* modes = std::get_if<GrblModes>(&answer)) {
    if (modes_asked_at_) modes_ = *modes;
  }
}

void GrblLine::TakeBanner(std::vector<Event>& events) {
  if (std::exchange(home_failed_, false) && phase_ == Phase::kUp) {
    outstanding_.clear();
    outstanding_bytes_ = 0;
    return;
  }
  if (phase_ != Phase::kResetting) {
    // Nobody asked for it: power, the reset button, or the opening of the port.
    if (phase_ != Phase::kRefused) ++power_ups_;
    LosePlace();
    reach_.reset();
    if (up()) Lose("the controller was reset or switched off", events);
    phase_ = Phase::kAsking;
    return;
  }
  outstanding_.clear();
  outstanding_bytes_ = 0;
  phase_at_ = now();
  if (resets_itself_) {
    phase_ = Phase::kUp;
    resets_itself_ = false;
    awaits_status_ = true;
    next_status_ = {};
    if (!alarm_) SetUp();
    return;
  }
  phase_ = Phase::kIdentifying;
  traits_ = {};
  SendOwn({"$I", "$$"});
}

void GrblLine::TakeAcknowledgement(bool good, int code, std::vector<Event>& events) {
  if (outstanding_.empty()) return;
  const Sent sent = outstanding_.front();
  outstanding_.pop_front();
  outstanding_bytes_ -= sent.bytes;
  if (std::exchange(homing_, false)) {
    if (good) {
      alarm_ = false;
      lost_axes_ = {};
      events.emplace_back(GrblHomed{});
      SetUp();
    } else {
      events.emplace_back(GrblError{code});
    }
    return;
  }
  if (!sent.own) {
    if (good) {
      events.emplace_back(GrblOk{});
    } else {
      events.emplace_back(GrblError{code});
    }
    return;
  }
  if (phase_ == Phase::kIdentifying && outstanding_.empty()) Identified(events);
  if (!setting_up_) return;
  if (!good) {
    setting_up_ = false;
    events.emplace_back(GrblNotSetUp{code});
  }
  if (outstanding_.empty() && setting_up_) {
    setting_up_ = false;
    set_up_ = awaits_status_ = true;
    next_status_ = {};
  }
}

// Door:0 is latched: it was open, and may have been while nobody listened.
void GrblLine::WatchChain(const GrblStatus& status) {
  const bool door = status.state == GrblState::kDoor;
  const bool open =
      (door && status.substate != 0) || status.pins.find('D') != std::string::npos;
  const bool stop = status.pins.find_first_of(kStopPins) != std::string::npos;
  const bool opens = (open && !door_open_) || (stop && !stop_pressed_);
  if (opens || (door && !open && !door_latched_)) ++chain_openings_;
  door_open_ = open;
  door_latched_ = door;
  stop_pressed_ = stop;
}

// The offset comes with some statuses only.
void GrblLine::TakeStatus(GrblStatus status, std::vector<Event>& events) {
  alarm_ = status.state == GrblState::kAlarm;
  WatchChain(status);
  if (status.work_offset_mm) work_offset_mm_ = *status.work_offset_mm;
  if (!status.work_mm)
    status.work_mm = *status.machine_mm - work_offset_mm_.value_or(Vec3::Zero());
  if (!status.machine_mm && work_offset_mm_)
    status.machine_mm = *status.work_mm + *work_offset_mm_;
  if (alarm_) LosePlace();
  if (phase_ == Phase::kUp) {
    if (alarm_) set_up_ = false;
    awaits_status_ = false;
    events.emplace_back(std::move(status));
    return;
  }
  if (phase_ != Phase::kAsking) return;
  if (status.state == GrblState::kDoor && status.substate != 0) {
    message_ = "the safety door is open: close it";
    return;
  }
  if (status.state == GrblState::kHold && !held_) found_held_ = true;
  if (!status.at_rest()) {
    if (status.state != GrblState::kHold && !std::exchange(held_, true)) out_ += '!';
    return;
  }
  held_ = false;
  if (AwaitsModes(status)) return;
  if (WasSwitchedOff(status)) {
    ++power_ups_;
    LosePlace();
  }
  reach_.reset();
  modes_asked_at_.reset();
  out_ = kGrblReset;
  phase_ = Phase::kResetting;
  phase_at_ = now();
}

// On hold and behind a door it takes no line.
bool GrblLine::AwaitsModes(const GrblStatus& status) {
  const bool ask = reach_ && was_set_up_ && status.state == GrblState::kIdle;
  if (!ask || modes_) return false;
  if (modes_asked_at_) return now() - *modes_asked_at_ <= kGrblSilence;
  modes_asked_at_ = now();
  out_ += "$G\n";
  return true;
}

// In the time in which the line was down.
bool GrblLine::WasSwitchedOff(const GrblStatus& status) const {
  if (!reach_) return false;
  if (!IsWithin(*reach_, *status.work_mm)) return true;
  if (modes_) return modes_->as_after_reset;
  // One that homes is locked then.
  return !traits_.homing && status.machine_mm &&
         status.machine_mm->cwiseAbs().maxCoeff() < kAtZero_mm;
}

void GrblLine::TakeZero(const std::array<bool, 3>& sets) {
  for (std::size_t i = 0; i < 3; ++i) lost_axes_[i] = lost_axes_[i] && !sets[i];
}

bool GrblLine::SendHome() {
  if (!is_ready() || !idle() || !out_.empty()) return false;
  homing_ = true;
  phase_at_ = now();
  SendOwn({"$H"});
  Write();
  return true;
}

void GrblLine::SendOwn(const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    out_ += line + "\n";
    outstanding_.push_back({line.size() + 1, true});
    outstanding_bytes_ += line.size() + 1;
  }
}

std::size_t GrblLine::Room() const {
  const auto capacity = static_cast<std::size_t>(traits_.receive_bytes);
  if (!takes_lines() || outstanding_bytes_ >= capacity) return 0;
  return capacity - outstanding_bytes_;
}

bool GrblLine::Send(const std::vector<std::string>& lines) {
  std::size_t bytes = 0;
  for (const std::string& line : lines) bytes += line.size() + 1;
  if (bytes > Room()) return false;
  for (const std::string& line : lines) {
    out_ += line + "\n";
    outstanding_.push_back({line.size() + 1, false});
  }
  outstanding_bytes_ += bytes;
  Write();
  return true;
}

void GrblLine::SendRealtime(char command) {
  if (!stream_) return;
  out_ += command;
  Write();
}

void GrblLine::Reset() {
  if (phase_ != Phase::kUp) return;
  out_ = kGrblReset;  // what is not written yet never is
  phase_ = Phase::kResetting;
  phase_at_ = now();
  resets_itself_ = true;
  set_up_ = setting_up_ = homing_ = false;
  Write();
}

void GrblLine::Ask() {
  if (phase_ == Phase::kResetting || phase_ == Phase::kIdentifying || homing_) return;
  if (now() < next_status_ || out_.find('?') != std::string::npos) return;
  next_status_ = now() + kQuestionPeriod;
  if (!asked_at_) asked_at_ = now();
  out_ += '?';
}

void GrblLine::Lose(std::string why, std::vector<Event>& events) {
  const bool was_up = up();
  if (was_up) was_set_up_ = set_up_;
  modes_asked_at_.reset();
  modes_.reset();
  message_ = std::move(why);
  phase_ = Phase::kAsking;
  resets_itself_ = set_up_ = setting_up_ = held_ = homing_ = home_failed_ = false;
  awaits_status_ = false;
  outstanding_.clear();
  outstanding_bytes_ = 0;
  out_.clear();
  refusal_.clear();
  asked_at_.reset();
  phase_at_ = now();
  if (was_up) events.emplace_back(GrblLost{});
}

void GrblLine::CheckSilence(std::vector<Event>& events) {
  if (homing_) {
    if (now() - phase_at_ > kHomeTimeout)
      Lose("the controller has not ended homing for 5 minutes: check its switches",
           events);
    return;
  }
  if (phase_ == Phase::kUp || phase_ == Phase::kRefused) {
    if (asked_at_ && now() - *asked_at_ > kGrblSilence) {
      Lose("the controller has not answered for 250 ms: check its power and the cable",
           events);
    }
    return;
  }
  const bool waits = phase_ == Phase::kResetting || phase_ == Phase::kIdentifying;
  if (waits && now() - phase_at_ > (resets_itself_ ? 250ms : kStepTimeout)) {
    Lose("the controller does not answer a reset: check its power and the cable", events);
  }
}

}  // namespace intaglio::drivers
