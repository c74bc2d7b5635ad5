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

/// Of all courses of a feasible step that which goes least far beyond its ends: at full
/// acceleration to one speed, and at full acceleration from it.
Arcs HardestArcs(double start_mm_s, double end_mm_s, double distance_mm, double seconds,
                 const AxisLimits& limits);

// ---- Written here to be compiled into the loops of the planner. ----
//
// The fastest end from speed v over distance d in time T: brake at A for T - u, then
// accelerate for u.
//   d  = v T - A T^2 / 2 + A u^2,   v' = v + A (2u - T)
//   (A u)^2 = A (d - v T) + (A T)^2 / 2
// dv'/dv = 1 - T / u <= 0, so of an interval of start speeds the least one ends fastest.
// Where the lowest speed on the way, v - A (T - u), falls below -V the axis holds -V for
// a while: with t = (v + V) / A the time to brake to it,
//   d  = (v - V) t / 2 - V (T - t) + A u^2 / 2,   v' = -V + A u.
// The slowest end is the mirror image: v, d -> -v, -d.
//
// The least usable start accelerates all the way and ends at V or below. It falls short
// of V T by m = V T - d:
//   it reaches V after s = sqrt(2 m / A) < T:   v = V - A s
//   it does not:                                v = d / T - A T / 2.

namespace axis_reach {

inline double LeastStart(double distance_mm, double seconds, const AxisLimits& limits) {
  const double a = limits.max_acceleration_mm_s2;
  const double short_mm = limits.max_speed_mm_s * seconds - distance_mm;
  const double rise_mm_s = std::sqrt(2 * a * short_mm);
  if (rise_mm_s < a * seconds) return limits.max_speed_mm_s - rise_mm_s;
  return distance_mm / seconds - 0.5 * a * seconds;
}

inline double FastestEnd(double v, double d, double seconds, const AxisLimits& limits) {
  const double a = limits.max_acceleration_mm_s2;
  const double top = limits.max_speed_mm_s;
  const double all = a * seconds;
  const double square = a * (d - v * seconds) + 0.5 * all * all;
  const double rise = std::min(std::sqrt(std::max(square, 0.0)), all);
  if (v - all + rise >= -top) return std::min(top, v + 2 * rise - all);
  const double t = (v + top) / a;
  const double held = 2 / a * (d - 0.5 * (v - top) * t + top * (seconds - t));
  return std::min(top, -top + a * std::sqrt(std::max(held, 0.0)));
}

}  // namespace axis_reach

inline SpeedInterval UsableStartSpeeds(double distance_mm, double seconds,
                                       const AxisLimits& limits) {
  const double top = limits.max_speed_mm_s;
  if (std::abs(distance_mm) > top * seconds) return {1, 0};
  return {std::max(-top, axis_reach::LeastStart(distance_mm, seconds, limits)),
          std::min(top, -axis_reach::LeastStart(-distance_mm, seconds, limits))};
}

inline SpeedInterval ReachableEndSpeeds(const SpeedInterval& start, double distance_mm,
                                        double seconds, const AxisLimits& limits) {
  const double hi = axis_reach::FastestEnd(start.lo, distance_mm, seconds, limits);
  const double lo = -axis_reach::FastestEnd(-start.hi, -distance_mm, seconds, limits);
  // Where one end is all that is left, rounding may cross the two.
  return {std::min(lo, hi), hi};
}

}  // namespace intaglio::motion
