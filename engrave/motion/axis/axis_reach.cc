#include "engrave/motion/axis/axis_reach.h"

#include <algorithm>
#include <cmath>

// The gentlest course has arcs of equal acceleration a. With D = d - (v + v') T / 2 >= 0
// it speeds up first (else mirror), and with w = v' - v
//   two arcs:    a^2 T^2 - 4 D a - w^2 = 0
//   held at V:   a = ((V - v)^2 + (V - v')^2) / (2 (V T - d)).
// At full acceleration A the way with a cruise at c, which grows with c, is
//   c T - ((c - v) |c - v| + (c - v') |c - v'|) / (2 A).

namespace intaglio::motion {

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

Arcs HardestArcs(double start_mm_s, double end_mm_s, double distance_mm, double seconds,
                 const AxisLimits& limits) {
  const double a = limits.max_acceleration_mm_s2;
  const double gentle =
      GentlestArcs(start_mm_s, end_mm_s, distance_mm, seconds, limits.max_speed_mm_s)
          .cruise_mm_s;
  const auto way_mm = [&](double cruise) {
    const double first = cruise - start_mm_s, last = cruise - end_mm_s;
    return cruise * seconds - 0.5 * (first * std::abs(first) + last * std::abs(last)) / a;
  };
  // The gentlest course goes furthest to one side, so the speed lies on the other side of
  // it.
  const bool above = distance_mm >= 0.5 * (start_mm_s + end_mm_s) * seconds;
  double lo = above ? std::min(start_mm_s, end_mm_s) : gentle;
  double hi = above ? gentle : std::max(start_mm_s, end_mm_s);
  for (double cruise = 0.5 * (lo + hi); lo < cruise && cruise < hi;
       cruise = 0.5 * (lo + hi)) {
    (way_mm(cruise) < distance_mm ? lo : hi) = cruise;
  }
  return {std::abs(lo - start_mm_s) / a, std::abs(lo - end_mm_s) / a, lo, a};
}

}  // namespace intaglio::motion
