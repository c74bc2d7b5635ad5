#pragma once

// One axis, one step: what end speeds can be reached, and with which course. The step
// goes `distance_mm` (signed) in exactly `seconds` > 0; |speed| <= max_speed_mm_s,
// |acceleration| <= max_acceleration_mm_s2, the latter free to jump.
//
// The pairs (start speed, end speed) of a step are a convex set, so from an interval of
// start speeds an interval of end speeds is reached, and limits per axis make the axes
// independent: the velocities reachable at a point are a box, exactly.

#include <algorithm>
#include <cmath>

#include "engrave/motion/axis/profile.h"

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

/// Of all courses within the speed limit the one with the minimum peak acceleration. The
/// step is feasible exactly when that is within the acceleration limit. Both speeds are
/// within the speed limit, and the distance is shorter than the limit times `seconds`.
Arcs GentlestArcs(double start_mm_s, double end_mm_s, double distance_mm, double seconds,
                  double max_speed_mm_s);

/// Of all courses of a feasible step the one that goes least far beyond its ends: at full
/// acceleration to one speed, and at full acceleration from it.
Arcs HardestArcs(double start_mm_s, double end_mm_s, double distance_mm, double seconds,
                 const AxisLimits& limits);

// ---- Written here to be compiled into the loops of the planner. ----
//
// The fastest end from speed v over distance d in time T: brake at A for T - u, then
// accelerate for u.
//   d  = v T - A T^2 / 2 + A u^2,   v' = v + A (2u - T)
//   (A u)^2 = A (d - v T) + (A T)^2 / 2
// dv'/dv = 1 - T / u <= 0, so of an interval of start speeds the lowest one ends fastest.
// Where the lowest speed on the way, v - A (T - u), falls below -V the axis holds -V for
// a while: with t = (v + V) / A the time to brake to it,
//   d  = (v - V) t / 2 - V (T - t) + A u^2 / 2,   v' = -V + A u.
// The slowest end is the mirror image: v, d -> -v, -d.
//
// The lowest usable start speed accelerates all the way and ends at V or below. It falls
// short of V T by m = V T - d:
//   it reaches V after s = sqrt(2 m / A) < T:   v = V - A s
//   it does not:                                v = d / T - A T / 2.
//
// An interval and its mirror image go through the same formulas, so both of its ends are
// computed at once, in two lanes.

/// An interval as its lower end and that of its mirror image: {lo, -hi}.
using SpeedEnds [[gnu::vector_size(16)]] = double;

inline SpeedEnds EndsOf(const SpeedInterval& speeds) {
  return SpeedEnds{speeds.lo, -speeds.hi};
}
inline SpeedInterval IntervalOf(SpeedEnds ends) { return {ends[0], -ends[1]}; }
inline bool IsEmpty(SpeedEnds ends) { return !(ends[0] <= -ends[1]); }
inline SpeedEnds Intersection(SpeedEnds a, SpeedEnds b) { return a < b ? b : a; }

/// One axis over a step: what it takes from one interval to the next.
class AxisReach {
 public:
  AxisReach(double distance_mm, double seconds, const AxisLimits& limits)
      : distance_mm_{distance_mm, -distance_mm},
        seconds_(seconds),
        acceleration_(limits.max_acceleration_mm_s2),
        top_(limits.max_speed_mm_s),
        gain_mm_s_(acceleration_ * seconds) {}

  /// UsableStartSpeeds.
  SpeedEnds Usable() const {
    if (std::abs(distance_mm_[0]) > top_ * seconds_) return SpeedEnds{1, 0};
    const SpeedEnds short_mm = top_ * seconds_ - distance_mm_;
    const SpeedEnds rise = Root(2 * acceleration_ * short_mm);
    const SpeedEnds smallest =
        rise < gain_mm_s_ ? top_ - rise
                          : distance_mm_ / seconds_ - 0.5 * acceleration_ * seconds_;
    return smallest > -top_ ? smallest : Both(-top_);
  }

  /// ReachableEndSpeeds.
  SpeedEnds After(SpeedEnds start) const {
    const SpeedEnds fastest = FastestEnds(start);
    const SpeedEnds slowest{-fastest[1], -fastest[0]};
    // Where one end is all that is left, rounding may cross the two.
    return SpeedEnds{fastest[0] < slowest[0] ? fastest[0] : slowest[0], slowest[1]};
  }

 private:
  static SpeedEnds Both(double value) { return SpeedEnds{value, value}; }
  static SpeedEnds Root(SpeedEnds square) {
    return SpeedEnds{std::sqrt(square[0]), std::sqrt(square[1])};
  }

  SpeedEnds FastestEnds(SpeedEnds v) const {
    const SpeedEnds square =
        acceleration_ * (distance_mm_ - v * seconds_) + 0.5 * gain_mm_s_ * gain_mm_s_;
    const SpeedEnds root = Root(square < 0.0 ? Both(0) : square);
    const SpeedEnds rise = gain_mm_s_ < root ? Both(gain_mm_s_) : root;
    const SpeedEnds free = v + 2 * rise - gain_mm_s_;
    const SpeedEnds lowest = v - gain_mm_s_ + rise;
    SpeedEnds end = free;
    if (lowest[0] < -top_ || lowest[1] < -top_) {
      const SpeedEnds t = (v + top_) / acceleration_;
      const SpeedEnds square_s =
          2 / acceleration_ *
          (distance_mm_ - 0.5 * (v - top_) * t + top_ * (seconds_ - t));
      const SpeedEnds held =
          -top_ + acceleration_ * Root(square_s < 0.0 ? Both(0) : square_s);
      end = lowest < -top_ ? held : free;
    }
    return end < top_ ? end : Both(top_);
  }

  SpeedEnds distance_mm_;
  double seconds_;
  double acceleration_;  ///< mm/s^2
  double top_;           ///< mm/s
  double gain_mm_s_;     ///< At full acceleration.
};

inline SpeedInterval UsableStartSpeeds(double distance_mm, double seconds,
                                       const AxisLimits& limits) {
  return IntervalOf(AxisReach(distance_mm, seconds, limits).Usable());
}

inline SpeedInterval ReachableEndSpeeds(const SpeedInterval& start, double distance_mm,
                                        double seconds, const AxisLimits& limits) {
  return IntervalOf(AxisReach(distance_mm, seconds, limits).After(EndsOf(start)));
}

}  // namespace intaglio::motion
