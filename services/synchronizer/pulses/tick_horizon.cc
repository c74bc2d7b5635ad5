#include "services/synchronizer/pulses/tick_horizon.h"

#include <algorithm>
#include <cmath>

#include "services/platform/link/laser_protocol.h"

namespace intaglio::synchronizer {
namespace {

// In real time the motion is this far ahead, the arms half as far: long enough for the
// journal's disk and a loaded host, short enough that a pause is felt at once.
constexpr double kAheadSeconds = 1.0;
// In lockstep the machine waits for us, so the windows only have to be worth a turn.
constexpr std::uint64_t kLockstepAheadTicks = 4096;
constexpr std::uint64_t kLockstepWindowTicks = 512;
// With a clock of its own also the controller's time is extrapolated that far.
constexpr std::uint64_t kMinOwnClockTicks = 64;

}  // namespace

void TickHorizon::Observe(std::chrono::nanoseconds now) {
  const std::pair status_number{laser_.session(), laser_.status_number()};
  if (!laser_.up() || status_number == status_number_) return;
  status_number_ = status_number;
  clock_.Observe(laser_.status(), now);
}

void TickHorizon::UseMotionClock(MotionClock* clock) {
  motion_clock_ = clock;
  if (clock != nullptr) clock->SetAhead(static_cast<double>(AheadTicks()));
}

std::uint64_t TickHorizon::AheadTicks() const {
  if (!lockstep()) {
    return static_cast<std::uint64_t>(std::ceil(kAheadSeconds * clock_.ticks_per_s())) +
           4;
  }
  if (!has_own_clock()) return kLockstepAheadTicks;
  return std::clamp(static_cast<std::uint64_t>(kAheadSeconds * rate_hz_),
                    kMinOwnClockTicks, kLockstepAheadTicks);
}

std::uint64_t TickHorizon::WindowTicks() const {
  if (lockstep()) return kLockstepWindowTicks;
  return std::clamp<std::uint64_t>(AheadTicks() / 2, 2, link::kMaxArmTicks);
}

std::size_t TickHorizon::IdleTicks() const {
  return has_own_clock() ? AheadTicks() : link::kMaxArmTicks;
}

}  // namespace intaglio::synchronizer
