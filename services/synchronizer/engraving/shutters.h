#pragma once

// The shutters of one engraving: open during a run, exactly those of its channels; closed
// at all other times, whatever happened before.
//
//   closed --Open(mask)--> opening --status shows the mask--> seen open
//     ^                                                          |
//     +---- status shows none <-- closing <--KeepClosed, every turn outside a run
//
// `seen open` makes the difference between a shutter that still travels and one that has
// closed under a run. Used from one thread; nothing waits.

#include <chrono>

#include "engrave/core/channels.h"
#include "services/drivers/interface/laser_controller.h"

namespace intaglio::synchronizer {

class Shutters {
 public:
  /// How long one may travel before it counts as stuck: real ones take below 100 ms.
  static constexpr std::chrono::seconds kTravelTimeout{2};

  explicit Shutters(drivers::LaserController& laser) : laser_(laser) {}

  /// Commands those of a run. False: the line takes nothing now, and nothing has changed.
  bool Open(ChannelMask mask, std::chrono::nanoseconds now);
  /// Once a turn outside a run: commands them closed until a status shows it. True when
  /// all are.
  bool KeepClosed(std::chrono::nanoseconds now);

  /// That have to be open for a pulse of the newest run, and no other; 0: none may fire.
  ChannelMask run_mask() const { return run_mask_; }
  /// The newest status shows exactly these open.
  bool are_open() const {
    return run_mask_ != 0 && laser_.status().shutters_open == run_mask_;
  }
  /// They are, or have been since Open: to be updated once a turn of a run.
  bool UpdateSeenOpen() { return seen_open_ = seen_open_ || are_open(); }
  bool was_seen_open() const { return seen_open_; }
  bool fails_to_open(std::chrono::nanoseconds now) const {
    return now - opened_at_ > kTravelTimeout;
  }
  /// KeepClosed has asked for longer than a shutter travels.
  bool fails_to_close(std::chrono::nanoseconds now) const {
    return closing_since_.count() >= 0 && now - closing_since_ > kTravelTimeout;
  }

 private:
  drivers::LaserController& laser_;
  ChannelMask run_mask_ = 0;
  bool seen_open_ = false;  // in this run
  std::chrono::nanoseconds opened_at_{0};
  std::chrono::nanoseconds closing_since_{-1};  // -1: all are closed
  std::chrono::nanoseconds next_close_{0};
};

}  // namespace intaglio::synchronizer
