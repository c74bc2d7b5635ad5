#pragma once

// Lamp and shutters by hand: switches what the motion bridge publishes as held by a
// person (ManualState; services/cell/manual/manual_control.h decides who may),
// for as long as it is.
//
//   closed --held, fresh, free, key and door--> disarming --disarmed()--> lit
//     ^                                                                    |
//     +--- let go, silent for kLease, a job, a stop, an interlock <--------+
//
// No pulse: nothing is armed here, and before anything is switched on the controller has
// confirmed a Disarm of this session. A state that was stored, or is the first of its
// bridge that came, switches nothing on: a second, newer one has to follow it.
//
// A lamp that was on already stays on when it is let go. Used from one thread; nothing
// waits.

#include <chrono>
#include <cstdint>

#include "idl/teach.h"
#include "services/drivers/interface/laser_controller.h"

namespace intaglio::synchronizer {

class LightByHand {
 public:
  /// The bridge publishes every 20 ms while it is commanded.
  static constexpr std::chrono::milliseconds kLease{100};

  /// `laser` outlives this; `rate_hz`: one of its rates, for the lamp.
  LightByHand(drivers::LaserController& laser, double rate_hz)
      : laser_(laser), rate_hz_(rate_hz) {}

  /// `alive`: its bridge is.
  void Receive(const intaglio_ManualState& state, bool alive,
               std::chrono::nanoseconds now);
  /// Once a turn without an engraving. `free`: no job waits for the laser, no stop holds.
  void Turn(bool free, std::chrono::nanoseconds now);
  /// An engraving has the laser: it closes the shutters itself.
  void Yield() { lamp_is_ours_ = shutters_are_ours_ = false; }
  /// Lamp or shutters are commanded here, or are to be taken back.
  bool holds() const { return lamp_is_ours_ || shutters_are_ours_; }

 private:
  bool MayLight(bool free, std::chrono::nanoseconds now) const;
  bool IsDisarmed();
  void TurnLamp(bool wanted);
  void TurnShutters(std::uint8_t wanted);

  drivers::LaserController& laser_;
  double rate_hz_;
  std::uint64_t number_ = 0;  // of the newest state
  bool held_lamp_ = false;
  std::uint8_t held_shutters_ = 0;
  std::chrono::nanoseconds at_{-1}, next_send_{0};
  std::uint64_t disarmed_session_ = 0;  // that a Disarm was sent in, for this hold
  // Commanded here, and to be taken back.
  bool lamp_is_ours_ = false, shutters_are_ours_ = false;
};

}  // namespace intaglio::synchronizer
