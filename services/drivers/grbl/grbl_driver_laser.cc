// The laser's side of the driver of the grbl family (grbl_driver.h).

#include <algorithm>

#include "services/drivers/grbl/grbl_driver.h"

namespace intaglio::drivers {

Status GrblDriver::Lamp(bool on, double rate_hz) {
  if (!up()) return Down();
  if (on && std::find(rates_hz_.begin(), rates_hz_.end(), rate_hz) == rates_hz_.end()) {
    return Fail(ErrorCode::kInvalidValue, "the profile has no such rate");
  }
  if (on && !lamp_on_) lamp_since_ = now();
  if (on) rate_hz_ = rate_hz;
  lamp_on_ = on;
  return {};
}

// The shutter of this family is M4: with M5 no line lights the laser.
Status GrblDriver::OpenShutters(std::uint8_t mask) {
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

Status GrblDriver::Arm(const link::ArmWindow& window) {
  if (!up()) return Down();
  if (window.at_place) {
    return Fail(ErrorCode::kUnsupported, "the controller does not compare places");
  }
  // Of a halt and a stop nothing comes back by itself.
  if (stop_ || safe_) {
    link::ArmWindow idle = window;
    idle.fire.assign(window.fire.size(), false);
    ticks_.Decide(idle);
    for (std::size_t i = 0; i < window.fire.size(); ++i) {
      if (window.fire[i]) ticks_.Refuse(window.first_tick + i);
    }
    return {};
  }
  ticks_.Decide(window);
  return {};
}

Status GrblDriver::Disarm() {
  if (!up()) return Down();
  ticks_.UndecideAfter(std::max(ticks_.tick(), committed_tick_));
  ++disarms_sent_;
  return {};
}

Status GrblDriver::Reset() {
  if (!up()) return Down();
  stop_ = false;
  if (!safe_) return {};
  leaving_safe_ = true;
  Recover();
  return {};
}

Status GrblDriver::Stop() {
  if (!up()) return Down();
  line_.Reset();
  Halt(intaglio_MOTION_SAFE_STATE, "stopped: check the block, then resume");
  stop_ = safe_ = true;
  return {};
}

Status GrblDriver::RequestStatus() {
  if (!up()) return Down();
  line_.RequestStatus();
  return {};
}

bool GrblDriver::RequestPast(std::uint64_t first_tick, std::uint16_t count) {
  if (!up()) return false;
  pasts_.push_back(ticks_.Past(first_tick, count));
  return true;
}

}  // namespace intaglio::drivers
