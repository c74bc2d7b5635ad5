#pragma once

// Which tick of the lamp it is now, and how far ahead of it motion and arms are decided.
//
// In real time: kAheadSeconds of the lamp's pace as our clock measures it. In lockstep
// the machine waits for us, so a fixed count of ticks; with a stage on a clock of its own
// no more than that clock is extrapolated. Used from one thread; neither allocates nor
// waits.

#include <chrono>
#include <cstdint>
#include <utility>

#include "services/drivers/interface/laser_controller.h"
#include "services/synchronizer/pulses/motion_clock.h"
#include "services/synchronizer/pulses/tick_clock.h"

namespace intaglio::synchronizer {

class TickHorizon {
 public:
  /// `rate_hz` > 0: of the lamp.
  TickHorizon(const drivers::LaserController& laser, double rate_hz)
      : laser_(laser), rate_hz_(rate_hz) {}

  /// Once a turn: takes the newest status.
  void Observe(std::chrono::nanoseconds now);
  /// The clock of the stage's controller; null: it runs on the lamp's ticks. The clock is
  /// set to how far ahead it is used.
  void UseMotionClock(MotionClock* clock);

  bool lockstep() const { return laser_.identity().lockstep; }
  /// The lamp's pace is known. In lockstep it does not matter.
  bool is_settled() const { return lockstep() || clock_.settled(); }
  std::uint64_t TickAt(std::chrono::nanoseconds now) const {
    return lockstep() ? laser_.status().tick : clock_.TickAt(now);
  }
  /// How far ahead of the newest tick motion is planned.
  std::uint64_t AheadTicks() const;
  /// Most ticks that are decided at once.
  std::uint64_t WindowTicks() const;
  /// Ticks that fire nothing, sent at once while nothing else is decided (lockstep).
  std::size_t IdleTicks() const;
  bool has_own_clock() const { return motion_clock_ != nullptr; }

 private:
  const drivers::LaserController& laser_;
  double rate_hz_;
  TickClock clock_;
  std::pair<std::uint64_t, std::uint64_t> status_number_{0, 0};  // session, number
  const MotionClock* motion_clock_ = nullptr;
};

}  // namespace intaglio::synchronizer
