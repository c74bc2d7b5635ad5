#include "engrave/motion/axis/jerk_reach.h"

#include <algorithm>
#include <cmath>

// A pulse is a trapezoid of acceleration: up at J, at most at A, down at J, and 0 at both
// ends. The largest in a time t gains
//   g(t) = J t^2 / 4 while t <= 2 h,   A (t - h) behind,   h = A / J,
// and being symmetric covers the mean of its end speeds times t.
//
// The fastest end from speed v over distance d in time T is a falling pulse of c, then a
// rising one of T - c (the weight of acceleration in the end speed, less a multiple of
// its weight T - t in the distance, grows along the step, so its sign changes once):
//   m(c) = -g(c) (T - c / 2) + g(T - c) (T - c) / 2 = d - v T,   v' = v - g(c) + g(T -
//   c).
// m falls with c. With both pulses of one kind it is quadratic:
//   c, T - c <= 2 h:   c^2 - 3 T c + T^2 = 8 m / (J T)
//   c, T - c >= 2 h:   2 c^2 - 4 T c + T^2 + h T = 2 m / A,
// otherwise cubic, solved by Newton's rule inside a bracket. As without a jerk limit
// dv'/dv <= 0, and where the speed would fall below -V it is held there; then
//   d = (v - V) t / 2 - V (T - t) + g(u) u / 2,   g(t) = v + V,   v' = -V + g(u).
// The lowest usable start speed rises all the way or to V; falling short of V T by m = V
// T - d, that is g(t) t / 2 = m and v = V - g(t) while t < T, else v = d / T - g(T) / 2.
//
// The gentlest course uses a share s of A and J, which leaves h as it is. With
// x = v' - v, D = |d - (v + v') T / 2| and a first pulse of f (rising where d is above
// the mean, else mirror):
//   x = s (g(f) - g(T - f)),   D = s (g(f) (T - f) + g(T - f) f) / 2,
// whose quotient rises with f.

namespace intaglio::motion {
namespace {

/// Where `falls`, a falling function, passes 0 in [lo, hi].
template <typename Function>
double RootOf(const Function& falls, double lo, double hi) {
  for (int halving = 0; halving < 200; ++halving) {
    const double middle = 0.5 * (lo + hi);
    if (middle <= lo || middle >= hi) break;
    (falls(middle) > 0 ? lo : hi) = middle;
  }
  return 0.5 * (lo + hi);
}

/// The time of the largest pulse with g(t) t / 2 = lag_mm.
double SecondsOfLag(double lag_mm, const JerkLimits& limits) {
  const double h = limits.max_acceleration_mm_s2 / limits.max_jerk_mm_s3;
  const double t = 2 * std::cbrt(lag_mm / limits.max_jerk_mm_s3);
  if (t <= 2 * h) return t;
  return 0.5 * (h + std::sqrt(h * h + 8 * lag_mm / limits.max_acceleration_mm_s2));
}

struct Lag {
  double value;  ///< m(c)
  double slope;
};

Lag LagOf(double c, double seconds, const JerkLimits& limits) {
  const auto slope = [&](double t) {
    return std::min(0.5 * limits.max_jerk_mm_s3 * t, limits.max_acceleration_mm_s2);
  };
  const double rest = seconds - c;
  const double fall = PulseGain(c, limits), rise = PulseGain(rest, limits);
  return {-fall * (seconds - 0.5 * c) + 0.5 * rise * rest,
          -slope(c) * (seconds - 0.5 * c) + 0.5 * fall - 0.5 * slope(rest) * rest -
              0.5 * rise};
}

/// c of m(c) = lag, one pulse with a flat top and the other without.
double SolveMixed(double lag_mm, double lo, double hi, double seconds,
                  const JerkLimits& limits) {
  double c = 0.5 * (lo + hi);
  for (int i = 0; i < 60; ++i) {
    const Lag at = LagOf(c, seconds, limits);
    (at.value > lag_mm ? lo : hi) = c;
    double next = c - (at.value - lag_mm) / at.slope;
    if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
    if (std::abs(next - c) <= 1e-15 * seconds) return next;
    c = next;
  }
  return c;
}

/// The time of the falling pulse.
double SolveFall(double lag_mm, double seconds, const JerkLimits& limits) {
  const double a = limits.max_acceleration_mm_s2, j = limits.max_jerk_mm_s3;
  const double flat = 2 * a / j;
  const double largest = 0.5 * PulseGain(seconds, limits) * seconds;
  const double m = std::clamp(lag_mm, -largest, largest);
  // Where the first and where the last pulse changes its kind.
  const double first = std::min(flat, seconds), last = std::max(seconds - flat, 0.0);
  const double early = std::min(first, last), late = std::max(first, last);
  const bool before = m >= LagOf(early, seconds, limits).value;
  const bool behind = !before && m <= LagOf(late, seconds, limits).value;
  if (before && early > 0) return SolveMixed(m, 0, early, seconds, limits);
  if (behind && late < seconds) return SolveMixed(m, late, seconds, seconds, limits);
  if (first >= last) {
    const double square = 5 * seconds * seconds + 32 * m / (j * seconds);
    return std::clamp(0.5 * (3 * seconds - std::sqrt(square)), 0.0, seconds);
  }
  const double square = seconds * seconds - 0.5 * flat * seconds + 2 * m / a;
  return seconds - std::sqrt(0.5 * std::max(square, 0.0));
}

double FastestEnd(double v, double d, double seconds, const JerkLimits& limits) {
  const double top = limits.max_speed_mm_s;
  const double c = SolveFall(d - v * seconds, seconds, limits);
  const double smallest = v - PulseGain(c, limits);
  if (smallest >= -top) return std::min(top, smallest + PulseGain(seconds - c, limits));
  const double t = PulseSeconds(v + top, limits);
  const double rest_mm = d - 0.5 * (v - top) * t + top * (seconds - t);
  return std::min(top, -top + PulseSpeedWithin(std::max(rest_mm, 0.0), limits));
}

double MinStart(double d, double seconds, const JerkLimits& limits) {
  const double short_mm = limits.max_speed_mm_s * seconds - d;
  const double t = SecondsOfLag(short_mm, limits);
  if (t < seconds) return limits.max_speed_mm_s - PulseGain(t, limits);
  return d / seconds - 0.5 * PulseGain(seconds, limits);
}

/// Both pulses held at `top` in between; the speeds are below it.
Pulses HeldPulses(double from_mm_s, double to_mm_s, double short_mm, double top,
                  const JerkLimits& limits) {
  const auto lag = [&](double root) {
    const double first = PulseSeconds(from_mm_s / (root * root), limits);
    const double last = PulseSeconds(to_mm_s / (root * root), limits);
    return 0.5 * (from_mm_s * first + to_mm_s * last) - short_mm;
  };
  // In the root of the share, so that small ones are found as well.
  double hi = 1;
  while (lag(hi) > 0 && hi < 1e6) hi *= 2;
  const double root = RootOf(lag, 0, hi);
  const double share = root * root;
  return {PulseSeconds(from_mm_s / share, limits), PulseSeconds(to_mm_s / share, limits),
          top, share};
}

/// The split of the time between two pulses that fill it.
double FirstSeconds(double gain_mm_s, double excess_mm, double seconds,
                    const JerkLimits& limits) {
  const auto falls = [&](double f) {
    const double first = PulseGain(f, limits), last = PulseGain(seconds - f, limits);
    return 0.5 * gain_mm_s * (first * (seconds - f) + last * f) -
           excess_mm * (first - last);
  };
  return RootOf(falls, 0, seconds);
}

}  // namespace

double PulseGain(double seconds, const JerkLimits& limits) {
  const double h = limits.max_acceleration_mm_s2 / limits.max_jerk_mm_s3;
  if (seconds <= 2 * h) return 0.25 * limits.max_jerk_mm_s3 * seconds * seconds;
  return limits.max_acceleration_mm_s2 * (seconds - h);
}

double PulseSeconds(double gain_mm_s, const JerkLimits& limits) {
  const double h = limits.max_acceleration_mm_s2 / limits.max_jerk_mm_s3;
  if (gain_mm_s <= limits.max_acceleration_mm_s2 * h) {
    return 2 * std::sqrt(gain_mm_s / limits.max_jerk_mm_s3);
  }
  return gain_mm_s / limits.max_acceleration_mm_s2 + h;
}

double PulseSpeedWithin(double distance_mm, const JerkLimits& limits) {
  return PulseGain(SecondsOfLag(distance_mm, limits), limits);
}

SpeedInterval UsableStartSpeeds(double distance_mm, double seconds,
                                const JerkLimits& limits) {
  const double top = limits.max_speed_mm_s;
  if (std::abs(distance_mm) > top * seconds) return {1, 0};
  return {std::max(-top, MinStart(distance_mm, seconds, limits)),
          std::min(top, -MinStart(-distance_mm, seconds, limits))};
}

SpeedInterval ReachableEndSpeeds(const SpeedInterval& start, double distance_mm,
                                 double seconds, const JerkLimits& limits) {
  const double hi = FastestEnd(start.lo, distance_mm, seconds, limits);
  const double lo = -FastestEnd(-start.hi, -distance_mm, seconds, limits);
  // Where one end is all that is left, rounding may cross the two.
  return {std::min(lo, hi), hi};
}

Pulses GentlestPulses(double start_mm_s, double end_mm_s, double distance_mm,
                      double seconds, const JerkLimits& limits) {
  const double excess_mm = distance_mm - 0.5 * (start_mm_s + end_mm_s) * seconds;
  const double sign = excess_mm >= 0 ? 1 : -1;
  const double gain_mm_s = sign * (end_mm_s - start_mm_s);
  const double d = std::abs(excess_mm);
  if (d == 0 && gain_mm_s == 0) return {0.5 * seconds, 0.5 * seconds, start_mm_s, 0};
  const double first_s = FirstSeconds(gain_mm_s, d, seconds, limits);
  const double last_s = seconds - first_s;
  const double first = PulseGain(first_s, limits), last = PulseGain(last_s, limits);
  // From both equations, weighed so that it does not matter when one of them vanishes.
  const double sum = (first * last_s + last * first_s) / seconds;
  const double difference = first - last;
  const double share = (2 * d / seconds * sum + gain_mm_s * difference) /
                       (sum * sum + difference * difference);
  const double cruise = start_mm_s + sign * share * first;
  if (std::abs(cruise) <= limits.max_speed_mm_s) return {first_s, last_s, cruise, share};
  const double top = sign * limits.max_speed_mm_s;
  // Rounding may leave a speed a last bit beyond the limit.
  return HeldPulses(std::max(sign * (top - start_mm_s), 0.0),
                    std::max(sign * (top - end_mm_s), 0.0),
                    sign * (top * seconds - distance_mm), top, limits);
}

Pulses HardestPulses(double start_mm_s, double end_mm_s, double distance_mm,
                     double seconds, const JerkLimits& limits) {
  const auto pulses_to = [&](double cruise) {
    return Pulses{PulseSeconds(std::abs(cruise - start_mm_s), limits),
                  PulseSeconds(std::abs(cruise - end_mm_s), limits), cruise, 1};
  };
  const auto left_mm = [&](double cruise) {
    const Pulses p = pulses_to(cruise);
    return distance_mm - cruise * seconds + 0.5 * (cruise - start_mm_s) * p.first_s +
           0.5 * (cruise - end_mm_s) * p.last_s;
  };
  const Pulses gentle =
      GentlestPulses(start_mm_s, end_mm_s, distance_mm, seconds, limits);
  const bool above = distance_mm >= 0.5 * (start_mm_s + end_mm_s) * seconds;
  const Pulses hardest = pulses_to(
      above ? RootOf(left_mm, std::min(start_mm_s, end_mm_s), gentle.cruise_mm_s)
            : RootOf(left_mm, gentle.cruise_mm_s, std::max(start_mm_s, end_mm_s)));
  return hardest.first_s + hardest.last_s <= seconds ? hardest : gentle;
}

}  // namespace intaglio::motion
