// The laser's side of the driver of isel's controllers (isel_driver.h).

#include <algorithm>

#include "services/drivers/isel/isel_driver.h"

namespace intaglio::drivers {

Status IselDriver::Lamp(bool on, double rate_hz) {
  if (!up()) return Down();
  if (on && std::find(rates_hz_.begin(), rates_hz_.end(), rate_hz) == rates_hz_.end())
    return Fail(ErrorCode::kInvalidValue, "the profile has no such rate");
  if (on && !lamp_on_) lamp_since_ = now();
  if (on) rate_hz_ = rate_hz;
  lamp_on_ = on;
  return {};
}

// There is none: without an open shutter no pulse is sent.
Status IselDriver::OpenShutters(std::uint8_t mask) {
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

Status IselDriver::Arm(const link::ArmWindow& window) {
  if (!up()) return Down();
  if (window.at_place)
    return Fail(ErrorCode::kUnsupported, "the controller does not compare places");
  if (!stop_ && !safe_) {
    ticks_.Decide(window);
    return {};
  }
  // Of a halt and a stop nothing comes back by itself.
  link::ArmWindow idle = window;
  idle.fire.assign(window.fire.size(), false);
  ticks_.Decide(idle);
  for (std::size_t i = 0; i < window.fire.size(); ++i) {
    if (window.fire[i]) ticks_.Refuse(window.first_tick + i);
  }
  return {};
}

Status IselDriver::Disarm() {
  if (!up()) return Down();
  ticks_.UndecideAfter(is_fired_ ? std::max(ticks_.tick(), pulse_tick_) : ticks_.tick());
  ++disarms_sent_;
  return {};
}

Status IselDriver::Reset() {
  if (!up()) return Down();
  stop_ = false;
  leaving_safe_ = safe_;
  return {};
}

// The move that is executed ends at once; the output is off but in a pulse.
Status IselDriver::Stop() {
  if (!up()) return Down();
  if (move_ || homing_) line_.SendStop();
  Halt(intaglio_MOTION_SAFE_STATE, "stopped: check the block, then resume");
  stop_ = safe_ = true;
  wanted_open_ = false;
  return {};
}

Status IselDriver::RequestStatus() {
  if (!up()) return Down();
  next_question_ = {};
  return {};
}

bool IselDriver::RequestPast(std::uint64_t first_tick, std::uint16_t count) {
  if (!up()) return false;
  pasts_.push_back(ticks_.Past(first_tick, count));
  return true;
}

}  // namespace intaglio::drivers
