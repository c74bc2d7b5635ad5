#pragma once

// Outputs and inputs of a laser controller for other uses: what a shop has beside the
// laser, as air, extraction, a lamp, a clamp. One object a controller; not thread-safe.
//
//   off --command, no interlock open--> on
//    ^                                   |
//    +--- SwitchOff: safe state, an interlock lets go, a new session <--+
//
// What was on does not come back by itself when the interlock closes: it takes another
// command. The inputs that a command has named stay watched over the end of its session,
// so that what lets go while no host listens is counted.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "services/platform/link/laser_protocol.h"

namespace intaglio::virtual_engraver {

class Accessories {
 public:
  /// `inputs`: their levels at power-up, one for each; both at most
  /// link::kMaxAccessories.
  Accessories(std::size_t output_count, const std::vector<bool>& inputs) {
    constexpr std::size_t kMax = link::kMaxAccessories;
    state_.output_count = static_cast<std::uint8_t>(std::min(output_count, kMax));
    state_.input_count = static_cast<std::uint8_t>(std::min(inputs.size(), kMax));
    for (std::size_t i = 0; i < state_.input_count; ++i) SetInput(i, inputs[i]);
  }

  void Watch(const link::AccessoryCommand& command) {
    watched_ = command.watched;
    needed_ = command.levels;
  }
  /// Outputs that the controller does not have are left out.
  void Switch(std::uint8_t on) {
    state_.on = static_cast<std::uint8_t>(on & ((1u << state_.output_count) - 1));
  }
  void SwitchOff() { state_.on = 0; }
  /// `input`: from 0, below the count.
  void SetInput(std::size_t input, bool on) {
    const auto bit = static_cast<std::uint8_t>(1u << input);
    state_.levels =
        static_cast<std::uint8_t>(on ? state_.levels | bit : state_.levels & ~bit);
  }

  /// Every watched input is as it was commanded. One that the controller does not have
  /// is off.
  bool hold() const { return ((state_.levels ^ needed_) & watched_) == 0; }
  const link::AccessoryState& state() const { return state_; }

 private:
  link::AccessoryState state_;
  std::uint8_t watched_ = 0, needed_ = 0;
};

}  // namespace intaglio::virtual_engraver
