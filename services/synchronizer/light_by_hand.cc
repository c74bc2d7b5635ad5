#include "services/synchronizer/light_by_hand.h"

namespace intaglio::synchronizer {
namespace {

// That of the controller's status.
constexpr std::chrono::milliseconds kSendPeriod{20};
// Numbers of one bridge have these bits in common.
constexpr int kProcessShift = 32;

}  // namespace

void LightByHand::Receive(const intaglio_ManualState& state, bool alive,
                          std::chrono::nanoseconds now) {
  const bool follows = alive && number_ != 0 && state.number > number_ &&
                       state.number >> kProcessShift == number_ >> kProcessShift;
  number_ = alive ? state.number : 0;
  held_lamp_ = follows && state.lamp_by_hand;
  held_shutters_ = follows ? state.shutters_by_hand : std::uint8_t{0};
  at_ = now;
}

bool LightByHand::MayLight(bool free, std::chrono::nanoseconds now) const {
  return free && at_.count() >= 0 && now - at_ < kLease && laser_.IsFresh(now) &&
         laser_.Has(link::kKeyOn) && laser_.Has(link::kDoorClosed) &&
         laser_.Has(link::kStopReleased);
}

void LightByHand::Turn(bool free, std::chrono::nanoseconds now) {
  const bool may = MayLight(free, now);
  const bool lamp = may && held_lamp_;
  const std::uint8_t shutters = may ? held_shutters_ : std::uint8_t{0};
  if (!lamp && shutters == 0) disarmed_session_ = 0;
  if (now < next_send_ || !laser_.CanSend()) return;
  next_send_ = now + kSendPeriod;
  if ((lamp || shutters != 0) && !IsDisarmed()) return;
  TurnLamp(lamp);
  TurnShutters(shutters);
}

// A safe state is left, too: a person is at the machine, and nothing is armed.
bool LightByHand::IsDisarmed() {
  if (disarmed_session_ != laser_.session()) {
    if (laser_.Disarm()) disarmed_session_ = laser_.session();
    return false;
  }
  if (!laser_.disarmed()) return false;
  if (!laser_.Has(link::kSafeState)) return true;
  laser_.SendReset();
  return false;
}

void LightByHand::TurnLamp(bool wanted) {
  const bool on = laser_.Has(link::kLampOn);
  if (wanted && !on) {
    lamp_is_ours_ = true;
    (void)laser_.Lamp(true, rate_hz_);
  } else if (!wanted && lamp_is_ours_) {
    if (on) (void)laser_.Lamp(false, rate_hz_);
    lamp_is_ours_ = on;
  }
}

void LightByHand::TurnShutters(std::uint8_t wanted) {
  const std::uint8_t open = laser_.status().shutters_open;
  if (wanted != 0 && open != wanted) {
    shutters_are_ours_ = true;
    (void)laser_.OpenShutters(wanted);
  } else if (wanted == 0 && shutters_are_ours_) {
    if (open != 0) (void)laser_.OpenShutters(0);
    shutters_are_ours_ = open != 0;
  }
}

}  // namespace intaglio::synchronizer
