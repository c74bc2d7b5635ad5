#pragma once

// The lamp between two jobs of a queue: it stays on after a job, with all shutters
// closed, so that the next one needs no warm-up.
//
//   off --Begin: a job has ended--> held --limit, a stop, the end of the process--> off
//                                    |
//                                    +--Yield: an engraving has the laser
//
// Nothing is armed meanwhile: a job ends disarmed. Used from one thread; nothing waits.

#include <chrono>

#include "services/drivers/interface/laser_controller.h"

namespace intaglio::synchronizer {

class LampHold {
 public:
  /// `laser` outlives this. `limit_s`: lamp_hold_s of the profile, 0..3600; 0: none is
  /// held. `rate_hz`: one of its rates, for the command that switches the lamp off.
  LampHold(drivers::LaserController& laser, double limit_s, double rate_hz)
      : laser_(laser),
        limit_(std::chrono::duration_cast<std::chrono::nanoseconds>(
            std::chrono::duration<double>(limit_s))),
        rate_hz_(rate_hz) {}

  /// An engraving leaves the lamp on when it ends.
  bool holds_lamps() const { return limit_.count() > 0; }
  /// A job has ended and has left the lamp on.
  void Begin(std::chrono::nanoseconds now) {
    held_ = holds_lamps();
    ends_at_ = now + limit_;
  }
  /// An engraving is given up that has left the lamp on: it goes off in the next turn.
  void End(std::chrono::nanoseconds now) {
    held_ = true;
    ends_at_ = now;
  }
  /// Once a turn without an engraving. `stopped`: a stop is pressed, or the process ends.
  void Turn(bool stopped, std::chrono::nanoseconds now) {
    if (!held_ || (!stopped && now < ends_at_)) return;
    // Again in the next turn when the line takes nothing now.
    if (laser_.Lamp(false, rate_hz_)) held_ = false;
  }
  /// An engraving switches the lamp itself.
  void Yield() { held_ = false; }
  bool holds() const { return held_; }

 private:
  drivers::LaserController& laser_;
  std::chrono::nanoseconds limit_, ends_at_{0};
  double rate_hz_;
  bool held_ = false;
};

}  // namespace intaglio::synchronizer
