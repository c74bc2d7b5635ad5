#pragma once

// The stops of the bus on the laser's controller, which keeps each latched, also over the
// end of this process.
//
//   free --pressed--> stopped --released by a person--> resetting --no latch--> free
//    ^                (Stop is sent once a session)         |
//    +----------------- kResetTime has passed --------------+
//
// The release of a stop that was held here is a person's fresh word: it takes the
// controller's own latch back, too, so that a machine without a job can be moved by hand
// again. Nothing is lit, armed or moved by it. The word is used up by the first status
// without a latch, and by a lost line, so that a later stop of the machine's button stays
// latched. While the button is pressed the controller stays latched, too; kResetTime
// later the word has lost its worth, and the stop has to be released once more. A stop
// that came before this process is not known here, so that no stored sample resets
// anything.
//
// Used from one thread; nothing waits.

#include <chrono>
#include <cstdint>
#include <limits>

#include "services/drivers/interface/laser_controller.h"

namespace intaglio::synchronizer {

class LaserStop {
 public:
  static constexpr std::chrono::milliseconds kResetTime{500};

  /// `laser` outlives this.
  explicit LaserStop(drivers::LaserController& laser) : laser_(laser) {}

  /// Once a turn. `pressed`: a stop of the bus holds; `rests`: no job is at work, and
  /// nothing is lit by hand.
  void Turn(bool pressed, bool rests, std::chrono::nanoseconds now) {
    if (pressed) return SendStop();
    if (held_) {
      resets_until_ = now + kResetTime;
      reset_behind_ = kNone;
      reset_session_ = laser_.session();
    }
    held_ = false;
    stopped_session_ = 0;
    if (IsUsedUp()) resets_until_ = now;
    if (now < resets_until_ && rests && laser_.status().shutters_open == 0) TryReset(now);
  }

 private:
  // That of the controller's status.
  static constexpr std::chrono::milliseconds kResetPeriod{20};

  void SendStop() {
    held_ = true;
    if (stopped_session_ == laser_.session() || !laser_.CanSend() || !laser_.Stop())
      return;
    stopped_session_ = laser_.session();
  }

  bool IsUsedUp() const {
    if (laser_.session() != reset_session_) return true;
    return laser_.status_number() > reset_behind_ && !laser_.is_latched();
  }

  void TryReset(std::chrono::nanoseconds now) {
    if (now < next_reset_ || !laser_.CanSend()) return;
    next_reset_ = now + kResetPeriod;
    laser_.SendReset();
    if (reset_behind_ == kNone) reset_behind_ = laser_.status_number();
  }

  static constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();

  drivers::LaserController& laser_;
  bool held_ = false;
  std::uint64_t stopped_session_ = 0;   ///< in which Stop was sent; 0: in none
  std::uint64_t reset_session_ = 0;     ///< in which the release came
  std::uint64_t reset_behind_ = kNone;  ///< status behind which the first Reset was sent
  std::chrono::nanoseconds resets_until_{0}, next_reset_{0};
};

}  // namespace intaglio::synchronizer
