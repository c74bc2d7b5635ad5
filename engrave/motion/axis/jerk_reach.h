#pragma once

// axis_reach.h for an axis whose jerk is limited too. A step goes `distance_mm` (signed)
// in exactly `seconds` > 0 with |speed|, |acceleration| and |jerk| within the limits and
// acceleration 0 at both ends.
//
// That the acceleration is 0 at every point is a restriction: it leaves the speed as the
// only state between steps, so intervals of speeds propagate exactly, as they do without
// a jerk limit. A planner that carried the acceleration over the points would be faster
// where steps are much shorter than the time to full acceleration.

#include "engrave/motion/axis/axis_reach.h"
#include "engrave/motion/axis/limits.h"

namespace intaglio::motion {

/// Limits of one axis; all > 0 and finite.
struct JerkLimits {
  double max_speed_mm_s = 0;
  double max_acceleration_mm_s2 = 0;
  double max_jerk_mm_s3 = 0;
};

/// Those of one axis, 0..2, whose jerk is limited.
inline JerkLimits JerkLimitsOf(const Limits& limits, int axis) {
  return {limits.max_speed_mm_s[axis], limits.max_acceleration_mm_s2[axis],
          limits.max_jerk_mm_s3[axis]};
}

/// The start speeds from which the step can be made at all; empty when it is too long.
SpeedInterval UsableStartSpeeds(double distance_mm, double seconds,
                                const JerkLimits& limits);

/// The end speeds reachable from `start`, which is within UsableStartSpeeds and not
/// empty. By reversal of time this is also the start speeds that lead to `start`.
SpeedInterval ReachableEndSpeeds(const SpeedInterval& start, double distance_mm,
                                 double seconds, const JerkLimits& limits);

/// The maximum speed gained in `seconds` from acceleration 0 to acceleration 0.
double PulseGain(double seconds, const JerkLimits& limits);
/// The minimum time to gain `gain_mm_s` >= 0.
double PulseSeconds(double gain_mm_s, const JerkLimits& limits);
/// The largest speed that can be braked to rest within `distance_mm` >= 0, or gained
/// from rest within it.
double PulseSpeedWithin(double distance_mm, const JerkLimits& limits);

/// A course of up to two pulses of acceleration: first_s long from the start speed to
/// cruise_mm_s, a time at it, and last_s long to the end speed.
struct Pulses {
  double first_s = 0;
  double last_s = 0;
  double cruise_mm_s = 0;
  /// Share of the limits of acceleration and jerk that the course needs.
  double share = 0;
};

/// Of all courses within the speed limit the one that needs the smallest share of the
/// limits of acceleration and jerk. The step is feasible exactly when that is at most 1.
/// Both speeds are within the speed limit, the distance is shorter than the limit times
/// `seconds`.
Pulses GentlestPulses(double start_mm_s, double end_mm_s, double distance_mm,
                      double seconds, const JerkLimits& limits);

/// The course with both pulses at the full limits and the rest of the time at one speed
/// in between, which goes least far beyond its ends; the gentlest where the time does
/// not allow that (then `share` is above a half). The step is feasible.
Pulses HardestPulses(double start_mm_s, double end_mm_s, double distance_mm,
                     double seconds, const JerkLimits& limits);

}  // namespace intaglio::motion
