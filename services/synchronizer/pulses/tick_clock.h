#pragma once

// The lamp's ticks by our own clock: from the controller's statuses, which
// arrive late by a while, the newest tick and how fast ticks really pass. A virtual
// machine may run at many times real time, a real one drifts by some parts in a million.

#include <chrono>
#include <cstdint>

#include "services/platform/link/laser_protocol.h"

namespace intaglio::synchronizer {

class TickClock {
 public:
  /// A status of the controller, at our monotonic time. A tick that goes back or another
  /// rate is another clock.
  void Observe(const link::LaserStatus& status, std::chrono::nanoseconds now);

  /// The tick that is likely by now; never less than the newest one reported.
  std::uint64_t TickAt(std::chrono::nanoseconds now) const;
  /// Ticks in a second of our clock; the nominal rate until it was seen for 50 ms.
  double ticks_per_s() const { return ticks_per_s_; }
  /// It was seen for 50 ms.
  bool settled() const { return settled_; }

 private:
  struct Sighting {
    std::uint64_t tick = 0;
    std::chrono::nanoseconds at{0};
  };
  double rate_hz_ = 0;
  double ticks_per_s_ = 0;
  bool settled_ = false;
  Sighting newest_, base_, next_base_;
};

}  // namespace intaglio::synchronizer
