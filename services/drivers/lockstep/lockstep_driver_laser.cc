// The laser's side of LockstepDriver.

#include <algorithm>
#include <utility>

#include "services/drivers/lockstep/lockstep_driver.h"

namespace intaglio::drivers {

using Outcome = link::TickOutcome;

void LockstepDriver::Poll(const ReportSink& sink, const PastSink& past) {
  Turn();
  if (!up()) return;
  for (const link::PulseReport& report : std::exchange(reports_, {})) sink(report);
  for (const link::PastReport& report : std::exchange(pasts_, {})) past(report);
}

double LockstepDriver::WarmRatio() const {
  if (!lamp_on_) return 0;
  const double on_s = std::chrono::duration<double>(now() - lamp_since_).count();
  return warm_up_s_ > 0 ? std::min(1.0, on_s / warm_up_s_) : 1;
}

std::optional<Outcome> LockstepDriver::WhyDark() const {
  if (stop_ || safe_ || halted_ || chain_is_open()) return Outcome::kInterlocked;
  if (WarmRatio() < 1) return Outcome::kLampNotReady;
  if (homing_ || !shutter_is_open()) return Outcome::kShutterClosed;
  return std::nullopt;
}

bool LockstepDriver::Fires(std::uint64_t tick) {
  if (!ticks_.fires(tick)) return false;
  const auto why = WhyDark();
  if (why) ticks_.Settle(tick, *why);
  return !why;
}

void LockstepDriver::ReportLaser() {
  for (auto& report : ticks_.TakeReports()) reports_.push_back(std::move(report));
  const bool closed = !chain_is_open();
  status_.tick = ticks_.tick();
  status_.machine_us =
      static_cast<std::uint64_t>(std::max<std::int64_t>(0, now().count() / 1000));
  status_.rate_hz = rate_hz_;
  status_.warm_ratio = WarmRatio();
  status_.interlocks = static_cast<std::uint8_t>(
      (closed ? link::kKeyOn | link::kDoorClosed : 0) |
      (closed && !stop_ ? link::kStopReleased : 0) | (lamp_on_ ? link::kLampOn : 0) |
      (WarmRatio() >= 1 ? link::kLampWarm : 0) | (safe_ ? link::kSafeState : 0));
  status_.shutters_open = !homing_ && shutter_is_open() ? 1 : 0;
  status_.pulse_count = ticks_.pulse_count();
  status_.last_fired_tick = ticks_.last_fired_tick();
  status_.decided_through = ticks_.decided_through();
  status_.openings = openings() + own_stops_;
  if (IsSettled()) status_.disarms_taken = disarms_sent_;
  if (!homing_) return;
  ++status_number_;
  status_at_ = now();
}

Status LockstepDriver::Lamp(bool on, double rate_hz) {
  if (!up()) return Down();
  if (on && std::find(rates_hz_.begin(), rates_hz_.end(), rate_hz) == rates_hz_.end())
    return Fail(ErrorCode::kInvalidValue, "the profile has no such rate");
  if (on && !lamp_on_) lamp_since_ = now();
  if (on) rate_hz_ = rate_hz;
  lamp_on_ = on;
  return {};
}

Status LockstepDriver::OpenShutters(std::uint8_t mask) {
  if (!up()) return Down();
  const bool may_open = !stop_ && (!safe_ || leaving_safe_);
  if ((mask & 1) != 0 && !may_open) {
    // Not kRefused, which asks to try again: only Reset helps.
    return Fail(ErrorCode::kInvalidValue,
                "the controller is in its safe state: reset it");
  }
  wanted_open_ = (mask & 1) != 0;
  return {};
}

Status LockstepDriver::Arm(const link::ArmWindow& window) {
  if (!up()) return Down();
  if (window.at_place)
    return Fail(ErrorCode::kUnsupported, "the controller does not compare places");
  if (!DwellsAtPoints()) {
    if (auto one = CheckOnePulse(window); !one) return one;
  }
  if (auto set = SetEnergy(window); !set) return set;
  if (!stop_ && !safe_) {
    ticks_.Decide(window);
    return {};
  }
  // After a halt or a stop nothing comes back by itself.
  link::ArmWindow idle = window;
  idle.fire.assign(window.fire.size(), false);
  ticks_.Decide(idle);
  for (std::size_t i = 0; i < window.fire.size(); ++i) {
    if (window.fire[i]) ticks_.Refuse(window.first_tick + i);
  }
  return {};
}

Status LockstepDriver::Disarm() {
  if (!up()) return Down();
  ticks_.UndecideAfter(std::max(ticks_.tick(), committed_tick_));
  ++disarms_sent_;
  return {};
}

Status LockstepDriver::Reset() {
  if (!up()) return Down();
  stop_ = false;
  if (!safe_) return {};
  leaving_safe_ = true;
  Recover();
  return {};
}

Status LockstepDriver::Stop() {
  if (!up()) return Down();
  StopController();
  Halt(intaglio_MOTION_SAFE_STATE, "stopped: check the block, then resume",
       StoppedBy::kHost);
  stop_ = safe_ = true;
  wanted_open_ = false;
  return {};
}

Status LockstepDriver::RequestStatus() {
  if (!up()) return Down();
  AskStatus();
  return {};
}

bool LockstepDriver::RequestPast(std::uint64_t first_tick, std::uint16_t count) {
  if (!up()) return false;
  pasts_.push_back(ticks_.Past(first_tick, count));
  return true;
}

}  // namespace intaglio::drivers
