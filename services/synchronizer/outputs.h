#pragma once

// The machine's outputs for other uses: what a shop switches with a job, as air or
// extraction. The least that serves it, on the path that shutters and lamp already have:
//
//  1. The profile names outputs and inputs; the laser's controller has them, and lists
//     their states behind its identity (link::AccessoryState). One that has none sends
//     nothing, and a profile that names some is refused.
//  2. An output is on only under a person's arm: the grant of the permission chain holds,
//     and has lit the lamp of this job (Synchronizer). Nothing else switches one on.
//  3. The controller switches them off by itself where it closes its shutters: safe
//     state, silence of the host, another session; and when key, door, stop or an input
//     opens. What was on does not come back without a command.
//  4. An input is a link of the permission chain beside key and door
//     (Missing::kInput), and an interlock of the controller, which counts its openings.
//
//   off --grant with lamp--> armed --a run is made--> engraves
//    ^                         |  ^----------------------+
//    +-- grant spent or withdrawn, job done, process ends --+
//
// Used from one thread; nothing waits.

#include <chrono>
#include <cstdint>

#include "services/drivers/interface/laser_controller.h"

namespace intaglio::synchronizer {

class Outputs {
 public:
  /// `laser` outlives this. Bits of its outputs: those of an arm, and those that are on
  /// while points are made.
  Outputs(drivers::LaserController& laser, std::uint8_t armed, std::uint8_t engraving)
      : laser_(laser), armed_(armed), engraving_(engraving) {}

  /// Once a turn. Sends what differs from what the controller reports.
  void Turn(bool armed, bool engraves, std::chrono::nanoseconds now) {
    const std::uint8_t wanted = !armed ? std::uint8_t{0} : engraves ? engraving_ : armed_;
    if (wanted == laser_.accessories().on) return;
    // What is to be off does not wait.
    if (now < next_send_ && wanted == wanted_) return;
    if (!laser_.CanSend() || !laser_.SwitchOutputs(wanted)) return;
    wanted_ = wanted;
    next_send_ = now + kSendPeriod;
  }
  /// The controller reports one on, and can be commanded.
  bool any_on() const { return laser_.up() && laser_.accessories().on != 0; }

 private:
  // That of the controller's status.
  static constexpr std::chrono::milliseconds kSendPeriod{20};

  drivers::LaserController& laser_;
  std::uint8_t armed_, engraving_;
  std::uint8_t wanted_ = 0;  // as sent last
  std::chrono::nanoseconds next_send_{0};
};

}  // namespace intaglio::synchronizer
