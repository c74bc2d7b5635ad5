#include <fmt/format.h>

#include <algorithm>

#include "services/synchronizer/engraving.h"

// What comes before a run: the right block in the machine, the lamp warm, the machine out
// of its safe state, the clocks known. In lockstep ticks pass meanwhile that fire
// nothing.

namespace intaglio::synchronizer {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kMostUnheardTicks = 16;

}  // namespace

void Engraving::Prepare(const EngravingInputs& inputs) {
  if (stopping_) return Finish();
  const std::string wait = WhatPreparationWaitsFor(inputs);
  // A fault that waits for the operator keeps its word.
  if (!faulted()) message_ = wait;
  if (wait.empty()) phase_ = Phase::kWaiting;
}

std::string Engraving::WhatPreparationWaitsFor(const EngravingInputs& inputs) {
  if (!job_.block_misfit.empty()) return job_.block_misfit;
  if (!laser_.refusal().empty()) return laser_.refusal();
  if (!laser_.up()) return TextOf(Missing::kLaserLine) + ": " + laser_.message();
  if (const auto can = job_.trigger->CheckLaser(laser_.identity()); !can)
    return can.error().message;
  LightLamp(inputs);
  LeaveSafeState(inputs);
  KeepIdleTicksPassing();
  const bool right_rate = laser_.status().rate_hz == job_.plan.rate_hz;
  if (!laser_.Has(link::kLampWarm) || !right_rate) {
    return fmt::format("the lamp warms up: {:.0f} %", 100 * laser_.status().warm_ratio);
  }
  if (!inputs.motion.fresh) return TextOf(Missing::kMotionState);
  return inputs.motion.line_down() ? inputs.motion.message : "";
}

// Once in a session: another session may be another power-up, and its lamp is off.
void Engraving::LightLamp(const EngravingInputs& inputs) {
  if (lamp_session_ == laser_.session() && laser_.Has(link::kLampOn)) return;
  if (inputs.now < next_request_ || !laser_.CanSend()) return;
  next_request_ = inputs.now + kRequestPeriod;
  if (laser_.Lamp(true, job_.plan.rate_hz)) lamp_session_ = laser_.session();
}

// In lockstep no tick passes that nobody decided: a lamp warms up by ticks, and a stage
// brakes by them.
void Engraving::KeepIdleTicksPassing() {
  if (!laser_.identity().lockstep || !laser_.CanSend()) return;
  if (disarm_session_ == laser_.session() && !disarm_seen_) {
    if (!disarm_asked_) (void)AskToDisarm();
    return;
  }
  const link::LaserStatus& status = laser_.status();
  // In a safe state or another session it has forgotten what was decided.
  const bool forgotten = laser_.session() != session_ || laser_.Has(link::kSafeState);
  decided_ = std::max({forgotten ? 0 : decided_, status.decided_through, status.tick});
  session_ = laser_.session();
  if (laser_.Has(link::kSafeState)) return;
  if (decided_ > status.tick) return;
  const std::size_t count = own_clock_ ? AheadTicks() : link::kMaxArmTicks;
  link::ArmWindow idle{decided_ + 1, true, std::vector<bool>(count, false)};
  if (!laser_.Arm(idle)) return;
  decided_ += idle.fire.size();
  (void)laser_.RequestStatus();
}

// On the operator's word, which is the grant.
void Engraving::LeaveSafeState(const EngravingInputs& inputs) {
  const bool latched = laser_.Has(link::kSafeState) || !laser_.Has(link::kStopReleased);
  if (!latched || !chain_.may_reset(LinksNow(inputs))) return;
  if (!laser_.CanSend() || inputs.now < next_request_) return;
  next_request_ = inputs.now + kRequestPeriod;
  (void)laser_.Reset();
  (void)laser_.RequestStatus();
}

// A stage on a clock of its own is moved only by a clock that is known.
bool Engraving::MotionClockSettles(const EngravingInputs& inputs) {
  own_clock_ = inputs.motion_clock != nullptr;
  if (!own_clock_) return true;
  inputs.motion_clock->SetAhead(static_cast<double>(AheadTicks()));
  if (inputs.motion_clock->settled()) {
    // A run begins behind what is decided: that is to have passed, and been heard of.
    return !laser_.identity().lockstep ||
           inputs.motion_clock->newest_tick() + kMostUnheardTicks >= decided_;
  }
  if (!started()) message_ = "the clock of the stage's controller is being measured";
  KeepIdleTicksPassing();
  return false;
}

// Where nothing can be fired, any will do.
ChannelMask Engraving::MaskOfNextRun() {
  open_points_.Rewind();
  return open_points_.mask() != 0 ? open_points_.mask() : job_.shutter_mask;
}

}  // namespace intaglio::synchronizer
