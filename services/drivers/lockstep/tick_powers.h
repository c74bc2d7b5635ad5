#pragma once

// A setting of the laser for the pulses that are decided, by their ticks: of a controller
// whose power, or whose pulses of a point, are part of its program. Used from one thread.

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>

namespace intaglio::drivers {

class TickPowers {
 public:
  /// `unset`: before the first that was set, and without any.
  explicit TickPowers(double unset = 1) : unset_(unset) {}

  /// Of the pulses of this tick and later ones, e.g. 0..1 of the largest power. What was
  /// decided for these ticks before is decided anew.
  void Set(std::uint64_t first_tick, double ratio) {
    ratios_.erase(ratios_.lower_bound(first_tick), ratios_.end());
    if (!ratios_.empty() && ratios_.rbegin()->second == ratio) return;
    ratios_.emplace(first_tick, ratio);
    if (ratios_.size() > kMaxChanges) ratios_.erase(ratios_.begin());
  }
  double At(std::uint64_t tick) const {
    const auto after = ratios_.upper_bound(tick);
    return after == ratios_.begin() ? unset_ : std::prev(after)->second;
  }

 private:
  /// Far more than the pulses that are decided and not given out.
  static constexpr std::size_t kMaxChanges = 4096;

  double unset_;
  std::map<std::uint64_t, double> ratios_;  ///< by the first tick that has it
};

}  // namespace intaglio::drivers
