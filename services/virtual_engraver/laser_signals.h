#pragma once

// What the parts of the laser need and give, whatever its controller is set to: lamp
// sync, Q-switch, photosensor, shutters. Times in us from the lamp sync, unless named.

#include "services/platform/link/laser_protocol.h"

namespace intaglio::virtual_engraver {

/// Defaults: Trochimczuk 2008, annexes C and D.
struct LaserSignals {
  /// The Q-switch gets every trigger so much later than the controller sends it;
  /// negative: earlier.
  double trigger_shift_us = 0;
  double trigger_max_delay_us = 20;   ///< a later trigger makes no pulse
  double trigger_min_width_us = 100;  ///< nor does a shorter one
  double sync_width_us = 5;           ///< of the lamp sync
  double sensor_width_us = 25;        ///< of the photosensor's signal for a flash
  double shutter_time_s = 0;          ///< until a shutter has opened or closed
};

/// Whether the laser makes a pulse of the controller's trigger. One that is sent by the
/// compare output, at a place, has no time from the lamp sync.
constexpr bool TakesTrigger(const LaserSignals& laser, const link::PulseTiming& sent,
                            bool at_place) {
  const double delay_us = sent.qswitch_delay_us + laser.trigger_shift_us;
  const bool in_time =
      at_place || (delay_us >= 0 && delay_us <= laser.trigger_max_delay_us);
  return in_time && sent.qswitch_width_us >= laser.trigger_min_width_us;
}

}  // namespace intaglio::virtual_engraver
