#pragma once

// One axis, one step: what end speeds can be reached, and with which course. The step
// goes `distance_mm` (signed) in exactly `seconds` > 0; |speed| <= max_speed_mm_s,
// |acceleration| <= max_acceleration_mm_s2, the latter free to jump.
//
// The pairs (start speed, end speed) of a step are a convex set, so from an interval of
// start speeds an interval of end speeds is reached, and limits per axis make the axes
// independent: the velocities reachable at a point are a box, exactly.

#include <algorithm>

#include "engrave/motion/profile.h"

namespace intaglio::motion {

/// lo <= hi, or empty. mm/s.
struct SpeedInterval {
  double lo = 0;
  double hi = 0;

  bool empty() const { return !(lo <= hi); }
  bool Contains(double speed_mm_s) const { return lo <= speed_mm_s && speed_mm_s <= hi; }
  bool Covers(const SpeedInterval& other) const {
    return lo <= other.lo && other.hi <= hi;
  }
  double Clamp(double speed_mm_s) const { return std::min(std::max(speed_mm_s, lo), hi); }
};

inline SpeedInterval Intersection(const SpeedInterval& a, const SpeedInterval& b) {
  return {std::max(a.lo, b.lo), std::min(a.hi, b.hi)};
}

/// The start speeds from which the step can be made at all; empty when it is too long.
SpeedInterval UsableStartSpeeds(double distance_mm, double seconds,
                                const AxisLimits& limits);

/// The end speeds reachable from `start`, which is within UsableStartSpeeds and not
/// empty. By reversal of time this is also the start speeds that lead to `start`.
SpeedInterval ReachableEndSpeeds(const SpeedInterval& start, double distance_mm,
                                 double seconds, const AxisLimits& limits);

/// A course of up to three arcs of constant acceleration: first_s from the start speed
/// to cruise_mm_s, a time at it, last_s to the end speed.
struct Arcs {
  double first_s = 0;
  double last_s = 0;
  double cruise_mm_s = 0;
  double peak_acceleration_mm_s2 = 0;
};

/// Of all courses within the speed limit that with the least peak acceleration. The
/// step is feasible exactly when that is within the acceleration limit. Both speeds are
/// within the speed limit, and the distance is shorter than the limit times `seconds`.
Arcs GentlestArcs(double start_mm_s, double end_mm_s, double distance_mm, double seconds,
                  double max_speed_mm_s);

}  // namespace intaglio::motion
