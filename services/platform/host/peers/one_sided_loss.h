#pragma once

// A network that fails in one direction for longer than a lease makes one of two
// participants lose the other. Without identities they find each other again; with them
// the DDS library does not: the participant that lost the other asks for a new handshake,
// and the other one, which has lost nothing, does not answer. The other one notices
// instead that its samples are no longer acknowledged by a participant that still renews
// its lease; it then leaves the domain for longer than a lease. After that both have lost
// each other and begin a new handshake.
//
// Only the acknowledgements of participants whose loss matters count (presence.h). A peer
// that never acknowledges, by a defect or on purpose, is not cured by leaving: each time
// that leaving did not help, the wait before the next one doubles, kMaxNotice at most.

#include <algorithm>
#include <chrono>

namespace intaglio::host {

class OneSidedLoss {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// Longer than the lease of a participant, 2 s (bus.cc): a dead one does not count.
  static constexpr std::chrono::milliseconds kNotice{3000};
  static constexpr std::chrono::milliseconds kMaxNotice{60000};
  static constexpr std::chrono::milliseconds kAway{2500};

  /// `all_acknowledged`: every matched reader has all that was written before now.
  /// True when it is time to leave for kAway.
  bool Turn(bool all_acknowledged, Time now) {
    if (all_acknowledged || acknowledged_ == Time{}) {
      acknowledged_ = now;
      notice_ = kNotice;
      return false;
    }
    if (now - acknowledged_ < notice_) return false;
    acknowledged_ = now + kAway;
    notice_ = std::min(2 * notice_, kMaxNotice);
    return true;
  }

 private:
  Time acknowledged_{};  // when all was, or the end of the last absence
  std::chrono::milliseconds notice_ = kNotice;
};

}  // namespace intaglio::host
