#pragma once

// Where the web is between two counts of its encoder, as the controller of a head knows
// it in each tick. A filter of second order (alpha-beta): at 100 kHz it has settled after
// 5 ms, and lags a web whose speed changes by a mm/s^2 by 1e-6 s^2 times that.

#include <cstdint>

namespace intaglio::virtual_engraver {

class WebCounter {
 public:
  /// At the end of each tick.
  void Update(std::int64_t count) {
    const auto read = static_cast<double>(count);
    if (!known_) count_ = read;
    known_ = true;
    count_ += rate_;
    const double off = read - count_;
    count_ += kPlaceGain * off;
    rate_ += kRateGain * off;
  }
  /// The count that many ticks after the newest.
  double Ahead(double ticks) const { return count_ + ticks * rate_; }

 private:
  static constexpr double kPlaceGain = 0.02, kRateGain = 0.0002;
  bool known_ = false;
  double count_ = 0, rate_ = 0;
};

}  // namespace intaglio::virtual_engraver
