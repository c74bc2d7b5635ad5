#pragma once

// The emergency stop of one cell as it is told on the bus. Pressed it stays, whoever
// pressed it and whatever becomes of him; only a reset with a higher number than every
// press that was heard releases it. A press that comes late or twice stops again: that
// costs a reset, the other way round it would cost a hand.

#include <algorithm>
#include <cstdint>

namespace intaglio::host {

class StopLatch {
 public:
  /// True when it was not pressed before and is now.
  bool Take(bool pressed, std::uint64_t number) {
    if (!pressed) {
      pressed_ = pressed_ && number <= number_;
      return false;
    }
    number_ = std::max(number_, number);
    const bool fresh = !pressed_;
    pressed_ = true;
    return fresh;
  }
  bool pressed() const { return pressed_; }
  /// Highest of a press; 0: none.
  std::uint64_t number() const { return number_; }

 private:
  bool pressed_ = false;
  std::uint64_t number_ = 0;
};

}  // namespace intaglio::host
