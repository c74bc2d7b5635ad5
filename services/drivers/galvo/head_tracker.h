#pragma once

// Where the web will be at a tick of the head's controller, by its samples of encoder and
// edge. Frame field: displacement is what is added to a place of the web; along x since
// the newest Restart.

#include <deque>
#include <optional>
#include <vector>

#include "engrave/galvo/web_follower.h"
#include "services/platform/link/scan_head_protocol.h"

namespace intaglio::drivers {

class HeadTracker {
 public:
  /// All >= 0; `count_mm` 0: there is no encoder, the web rests. `ahead_s`: how far ahead
  /// it is asked.
  HeadTracker(double count_mm, double edge_sensor_mm, double ahead_s);

  /// What another session or power-up measured is forgotten.
  void Forget();
  /// Samples of a rate of ticks, 1/s.
  void Receive(const link::HeadWeb& web, double rate_hz);
  /// The web is at 0 now.
  void Restart() { zero_mm_.reset(); }

  bool follows() const { return count_mm_ > 0; }
  /// It can be asked where the web is: also aside, when what the sensor of the edge
  /// measured first has come to the field.
  bool ready() const {
    return !follows() || (follower_ && newest_mm_.x() >= edge_sensor_mm_);
  }
  /// At the middle of this tick and `later_s` after it; {0, 0} of a web that rests.
  Vec2 At(std::uint64_t tick, double later_s);
  /// How far the web has moved then since the encoder's count `from`; once it is ready.
  Vec2 Since(double from, std::uint64_t tick, double later_s) const;
  /// The encoder's count then, and how many a tick there are; once it is ready.
  double CountAt(std::uint64_t tick, double later_s) const;
  double counts_per_tick() const { return speed_mm_s() / rate_hz_ / count_mm_; }
  double count_mm() const { return count_mm_; }
  /// How far the web was from where it had been expected `ahead_s` before, at most within
  /// the last seconds, mm.
  double surprise_mm() const { return surprise_mm_; }
  double ahead_s() const { return ahead_s_; }
  double speed_mm_s() const { return follower_ ? follower_->speed_mm_s() : 0; }

 private:
  void Begin(std::uint16_t step_ticks);
  void Follow(const link::HeadWebSample& sample);
  /// Since the first count, mm.
  double PlaceAt(std::uint64_t tick, double later_s) const;

  double count_mm_, edge_sensor_mm_, ahead_s_;
  double rate_hz_ = 1e5, period_s_ = 0;
  std::vector<link::HeadWebSample> first_;  // until its speed is known
  std::optional<galvo::WebFollower> follower_;
  std::int64_t first_count_ = 0;
  Vec2 newest_mm_ = Vec2::Zero();
  std::uint64_t newest_tick_ = 0;
  std::optional<double> zero_mm_;
  std::deque<double> expected_mm_;  // of the samples that come next
  double surprise_mm_ = 0;
};

}  // namespace intaglio::drivers
