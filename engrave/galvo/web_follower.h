#pragma once

// Where a moving web is, by its encoder and a sensor of its edge, for each tick of a scan
// head. Frame field: displacement is what is added to a place of the web; the encoder
// counts up when the web moves along +x.
//
// The encoder is coarse (23 um): its counts drive a tracker of place and speed
// (alpha-beta; Benedict and Bordner 1962, Synthesis of an Optimal Set of Radar
// Track-While-Scan Smoothing Equations), which is also asked where the web will be when
// the servo has followed. The edge is measured upstream: its reading is delayed by the
// way of the web from the sensor to the field, else a wave of the edge A of length l is
// marked wrong by up to 2 A sin(pi s / l).

#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::galvo {

struct WebFollowerOptions {
  double count_mm = 0.023;  ///< of the encoder, > 0
  double period_s = 1e-5;   ///< of a tick, > 0
  /// Gains of the tracker, at 100 kHz: settled within 5 ms, 1 um of the 23 of a count.
  double alpha = 0.02, beta = 0.0002;
  double preview_s = 0;  ///< lag of the servo; half a period for the hold is added
  double edge_sensor_upstream_mm = 0;  ///< from the centre of the field, >= 0
};

/// kInvalidValue: an option outside its range, by name.
Status CheckFollower(const WebFollowerOptions& options);

class WebFollower {
 public:
  /// `options` as of CheckFollower, else PreconditionError. The web has this count and
  /// speed at the first tick, and a straight edge before it.
  WebFollower(const WebFollowerOptions& options, std::int64_t count, double speed_mm_s);

  /// Once a tick: the encoder's count and how far the edge is along +y. The displacement
  /// since the first count, ahead by the preview; its place within the first count is not
  /// known, half a count either way. Neither allocates nor throws.
  Vec2 Update(std::int64_t count, double edge_mm);

  double speed_mm_s() const { return speed_mm_ / options_.period_s; }

 private:
  double EdgeInField(std::int64_t count, double edge_mm);

  WebFollowerOptions options_;
  std::int64_t first_count_, last_count_;
  double place_mm_ = 0, speed_mm_;  // speed: mm a tick
  double preview_ticks_;
  std::vector<double> edges_mm_;  // by count, a ring; of no use without a distance
};

}  // namespace intaglio::galvo
