#pragma once

// The source's speed profiles of one step from rest to rest, as formulas:
// Trochimczuk 2008 ch. 6.2, (12)-(15), and the cubic curve (16)-(20) with zero end
// speeds. Distances in mm >= 0, times in s.

#include <cstdint>

#include "engrave/core/geometry.h"
#include "engrave/motion/axis/limits.h"

namespace intaglio::motion {

/// How a step from rest to rest is driven.
enum class Profile {
  kTriangle,     ///< Accelerate half of the time, brake the other half.
  kTrapezoid,    ///< With a cruise at constant speed in between.
  kCubic,        ///< One cubic curve: acceleration falls linearly, no jump in the middle.
  kMix,          ///< By the step's length; default, the source's best (ch. 6.2).
  kTimeOptimal,  ///< The shortest time (81)-(87), then rest until the tick.
  kInterpolator,  ///< (99)-(104): every axis by itself, then rest until the tick.
  kParabola,      ///< 6.2.3-6.2.6: a leap over the line (parabola_program.h).
  kLq,            ///< 6.2.7: the minimum effort by dynamic programming (lq_program.h).
};

/// Limits of one axis; both > 0.
struct AxisLimits {
  double max_speed_mm_s = 0.0;
  double max_acceleration_mm_s2 = 0.0;
};

/// Those of one axis, 0..2.
inline AxisLimits LimitsOf(const Limits& limits, int axis) {
  return {limits.max_speed_mm_s[axis], limits.max_acceleration_mm_s2[axis]};
}

/// (15): T = 2 sqrt(s / a). Its peak speed is 2 s / T, whatever the speed limit.
double TriangleSeconds(double distance_mm, double acceleration_mm_s2);

/// (12)-(14): T = s / V + V / a, for steps long enough to reach V: sqrt(s a) >= V.
double TrapezoidSeconds(double distance_mm, const AxisLimits& limits);

/// The end of the ramp of a trapezoid of duration T over s at acceleration a,
/// t_s = T / 2 - sqrt(T^2 / 4 - s / a); T >= 2 sqrt(s / a), at equality a triangle.
double SwitchingSeconds(double duration_s, double distance_mm, double acceleration_mm_s2);

/// The cubic with zero end speeds has peak speed 1.5 s / T in its middle and peak
/// acceleration 6 s / T^2 at its ends: T = max(sqrt(6 s / a), 1.5 s / V).
double CubicSeconds(double distance_mm, const AxisLimits& limits);

/// The minimum time from rest to rest: (15) while sqrt(s a) <= V, else (12)-(14).
double StopAndGoSeconds(double distance_mm, const AxisLimits& limits);

/// The minimum time of a step under `profile`; kMix counts as the fastest of its parts.
/// Of kTriangle to kInterpolator; the others have no formula of it, which throws
/// PreconditionError.
double MinSeconds(Profile profile, double distance_mm, const AxisLimits& limits);

/// A step of three axes seen as one axis that goes 1 mm. All axes follow one common
/// course, so the axis with the largest |step| / V_max governs speed and the axis with
/// the largest |step| / a_max acceleration. With equal limits on the axes this is the
/// source's rule: the largest axis distance counts. `step_mm` is not zero.
AxisLimits UnitStepLimits(const Vec3& step_mm, const Limits& limits);

/// Whole ticks that a time takes: max(1, ceil(rate T)). A time longer than whole ticks
/// by a relative 1e-9 counts as these ticks: that is rounding, not motion, and costs at
/// most 2e-9 of the acceleration limit.
std::uint64_t WholeTicks(double seconds, double rate_hz);

/// The relative slack of WholeTicks.
inline constexpr double kTickSlackRatio = 1e-9;

}  // namespace intaglio::motion
