#pragma once

// A network that fails in one direction for longer than a lease makes one of two lose the
// other. Without identities they find each other again; with them the DDS library does
// not: who lost the other asks it to prove itself anew, and the other, to whom nothing
// has happened, does not answer such questions. Whoever has not lost it sees that what it
// writes is not acknowledged any more by somebody who seems to be alive. It then leaves
// the bus for longer than a lease: now all have lost it, it has lost all, and everybody
// proves himself afresh.

#include <chrono>

namespace intaglio::host {

class OneSidedLoss {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// Longer than the lease of a participant, 2 s (bus.cc): the dead are not waited for.
  static constexpr std::chrono::milliseconds kNotice{3000};
  static constexpr std::chrono::milliseconds kAway{2500};

  /// `all_acknowledged`: everybody who is matched has all that was written before now.
  /// True when it is time to leave for kAway.
  bool Turn(bool all_acknowledged, Time now) {
    if (all_acknowledged || heard_ == Time{}) {
      heard_ = now;
      return false;
    }
    if (now - heard_ < kNotice) return false;
    heard_ = now + kAway;
    return true;
  }

 private:
  Time heard_{};  // all was acknowledged, or we are back
};

}  // namespace intaglio::host
