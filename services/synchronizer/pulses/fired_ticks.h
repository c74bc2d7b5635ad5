#pragma once

// The ticks that a job has taken at the laser: from the first to the last pulse of each
// power-up, because each counts its ticks anew, of all lives of the synchronizer.

#include <algorithm>
#include <cstdint>
#include <map>
#include <span>

#include "engrave/formats/journal_file.h"

namespace intaglio::synchronizer {

class FiredTicks {
 public:
  /// What earlier lives fired; `power_up`: their newest.
  void TakeUp(std::span<const formats::PointHistory> points, std::uint32_t power_up) {
    std::map<std::uint32_t, FiredTicks> by_power_up;
    for (const formats::PointHistory& point : points)
      if (point.fired_count > 0) by_power_up[point.power_up].Add(point.tick);
    for (const auto& [one, ticks] : by_power_up) {
      if (one == power_up) {
        first_ = ticks.first_;
        last_ = ticks.last_;
      } else {
        closed_count_ += ticks.count();
      }
    }
  }
  void Add(std::uint64_t tick) {
    first_ = first_ == 0 ? tick : std::min(first_, tick);
    last_ = std::max(last_, tick);
  }
  /// From here on ticks are those of another power-up.
  void BeginPowerUp() {
    closed_count_ = count();
    first_ = last_ = 0;
  }
  /// Both are ticks of the newest power-up; 0: nothing was fired in it.
  std::uint64_t first() const { return first_; }
  std::uint64_t last() const { return last_; }
  std::uint64_t count() const {
    return closed_count_ + (first_ == 0 ? 0 : last_ - first_ + 1);
  }

 private:
  std::uint64_t closed_count_ = 0;  ///< of earlier power-ups
  std::uint64_t first_ = 0, last_ = 0;
};

}  // namespace intaglio::synchronizer
