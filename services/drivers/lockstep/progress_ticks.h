#pragma once

// The ticks of a controller that has none: which of them are decided, which fire, what
// became of each of the newest link::kRememberedTicks, and the reports of it in order.
// Ticks pass with the program (piece_queue.h), when the driver passes them.
//
// Used from one thread.

#include <cstdint>
#include <set>
#include <vector>

#include "services/platform/link/laser_protocol.h"

namespace intaglio::drivers {

class ProgressTicks {
 public:
  using Outcome = link::TickOutcome;

  /// What is decided already, or has passed, is reported as late where it was to fire.
  void Decide(const link::ArmWindow& window);
  /// A decided tick that was to fire, and does not: the controller is in its safe state.
  void Refuse(std::uint64_t tick);
  /// Undecides every tick after `tick`; what was to fire there never does.
  void UndecideAfter(std::uint64_t tick);

  std::uint64_t tick() const { return tick_; }
  std::uint64_t decided_through() const { return decided_through_; }
  bool fires(std::uint64_t tick) const { return fire_.count(tick) != 0; }
  bool gated(std::uint64_t tick) const { return ungated_.count(tick) == 0; }
  /// The first one after `tick` that is to fire and has no outcome; UINT64_MAX: none.
  std::uint64_t next_fire_after(std::uint64_t tick) const {
    const auto next = fire_.upper_bound(tick);
    return next == fire_.end() ? UINT64_MAX : *next;
  }

  /// The outcome of a tick that was to fire, once; it is reported when the tick passes,
  /// but for kNoLongerKnown, which only the answer to RequestPast has.
  void Settle(std::uint64_t tick, Outcome outcome);
  /// Everything up to `tick` has passed; a tick that was to fire and has no outcome was
  /// not in position.
  void PassThrough(std::uint64_t tick);

  std::vector<link::PulseReport> TakeReports();
  link::PastReport Past(std::uint64_t first_tick, std::uint16_t count) const;

  /// Pulses that are known to have been fired.
  std::uint64_t pulse_count() const { return pulse_count_; }
  std::uint64_t last_fired_tick() const { return last_fired_tick_; }

 private:
  void Remember(std::uint64_t tick, Outcome outcome);

  std::uint64_t tick_ = 0, decided_through_ = 0;
  std::set<std::uint64_t> fire_, ungated_;
  std::vector<Outcome> memory_ =
      std::vector<Outcome>(link::kRememberedTicks, Outcome::kNotArmed);
  std::set<std::uint64_t> settled_;  // and not passed
  std::vector<link::PulseReport> reports_;
  std::uint64_t pulse_count_ = 0, last_fired_tick_ = 0;
};

}  // namespace intaglio::drivers
