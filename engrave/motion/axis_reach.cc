#include "engrave/motion/axis_reach.h"

#include <cmath>

// The fastest end from speed v over distance d in time T: brake at A for T - u, then
// accelerate for u.
//   d  = v T - A T^2 / 2 + A u^2            u^2 = (d - v T) / A + T^2 / 2
//   v' = v + A (2u - T)
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
//
// The gentlest course has arcs of equal acceleration a. With D = d - (v + v') T / 2 >= 0
// it speeds up first (else mirror), and with w = v' - v
//   two arcs:    a^2 T^2 - 4 D a - w^2 = 0
//   held at V:   a = ((V - v)^2 + (V - v')^2) / (2 (V T - d)).

namespace intaglio::motion {
namespace {

double LeastStart(double distance_mm, double seconds, const AxisLimits& limits) {
  const double a = limits.max_acceleration_mm_s2;
  const double short_mm = limits.max_speed_mm_s * seconds - distance_mm;
  const double rise_mm_s = std::sqrt(2 * a * short_mm);
  if (rise_mm_s < a * seconds) return limits.max_speed_mm_s - rise_mm_s;
  return distance_mm / seconds - 0.5 * a * seconds;
}

double FastestEnd(double v, double d, double seconds, const AxisLimits& limits) {
  const double a = limits.max_acceleration_mm_s2;
  const double top = limits.max_speed_mm_s;
  const double u2 = (d - v * seconds) / a + 0.5 * seconds * seconds;
  const double u = std::min(std::sqrt(std::max(u2, 0.0)), seconds);
  if (v - a * (seconds - u) >= -top) return std::min(top, v + a * (2 * u - seconds));
  const double t = (v + top) / a;
  const double held = 2 / a * (d - 0.5 * (v - top) * t + top * (seconds - t));
  return std::min(top, -top + a * std::sqrt(std::max(held, 0.0)));
}

}  // namespace

SpeedInterval UsableStartSpeeds(double distance_mm, double seconds,
                                const AxisLimits& limits) {
  const double top = limits.max_speed_mm_s;
  if (std::abs(distance_mm) > top * seconds) return {1, 0};
  return {std::max(-top, LeastStart(distance_mm, seconds, limits)),
          std::min(top, -LeastStart(-distance_mm, seconds, limits))};
}

SpeedInterval ReachableEndSpeeds(const SpeedInterval& start, double distance_mm,
                                 double seconds, const AxisLimits& limits) {
  const double hi = FastestEnd(start.lo, distance_mm, seconds, limits);
  const double lo = -FastestEnd(-start.hi, -distance_mm, seconds, limits);
  // Where one end is all that is left, rounding may cross the two.
  return {std::min(lo, hi), hi};
}

Arcs GentlestArcs(double start_mm_s, double end_mm_s, double distance_mm, double seconds,
                  double max_speed_mm_s) {
  const double excess_mm = distance_mm - 0.5 * (start_mm_s + end_mm_s) * seconds;
  const double gain_mm_s = end_mm_s - start_mm_s;
  const double sign = excess_mm >= 0 ? 1 : -1;
  const double d = std::abs(excess_mm);
  const double a =
      (2 * d + std::sqrt(4 * d * d + seconds * seconds * gain_mm_s * gain_mm_s)) /
      (seconds * seconds);
  if (a == 0) return {0.5 * seconds, 0.5 * seconds, start_mm_s, 0};
  const double first_s = std::clamp(0.5 * (seconds + sign * gain_mm_s / a), 0.0, seconds);
  const double cruise = start_mm_s + sign * a * first_s;
  if (std::abs(cruise) <= max_speed_mm_s) return {first_s, seconds - first_s, cruise, a};

  const double top = sign * max_speed_mm_s;
  const double held =
      ((top - start_mm_s) * (top - start_mm_s) + (top - end_mm_s) * (top - end_mm_s)) /
      (2 * sign * (top * seconds - distance_mm));
  return {sign * (top - start_mm_s) / held, sign * (top - end_mm_s) / held, top, held};
}

}  // namespace intaglio::motion
