#pragma once

// The settings of the laser for the pulses that are decided, by their ticks: of a
// controller whose power is part of its program. Used from one thread.

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>

namespace intaglio::drivers {

class TickPowers {
 public:
  /// Of the pulses of this tick and later ones, 0..1 of the largest setting. What was
  /// decided for these ticks before is decided anew.
  void Set(std::uint64_t first_tick, double ratio) {
    ratios_.erase(ratios_.lower_bound(first_tick), ratios_.end());
    if (!ratios_.empty() && ratios_.rbegin()->second == ratio) return;
    ratios_.emplace(first_tick, ratio);
    if (ratios_.size() > kMaxChanges) ratios_.erase(ratios_.begin());
  }
  /// Before the first one that was set, and without any, it is 1.
  double At(std::uint64_t tick) const {
    const auto after = ratios_.upper_bound(tick);
    return after == ratios_.begin() ? 1 : std::prev(after)->second;
  }

 private:
  /// Far more than the pulses that are decided and not given out.
  static constexpr std::size_t kMaxChanges = 4096;

  std::map<std::uint64_t, double> ratios_;  ///< by the first tick that has it
};

}  // namespace intaglio::drivers
