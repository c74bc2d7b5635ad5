#include "engrave/motion/axis/interpolator.h"

#include <algorithm>
#include <cmath>

namespace intaglio::motion {

TimeOptimalChoice ChooseTimeOptimal(double length_mm, const AxisLimits& limits) {
  TimeOptimalChoice choice;
  choice.acceleration_mm_s2 = limits.max_acceleration_mm_s2;
  choice.speed_mm_s = std::min(std::sqrt(length_mm * limits.max_acceleration_mm_s2),
                               limits.max_speed_mm_s);
  choice.seconds =
      TrapezoidSeconds(length_mm, {choice.speed_mm_s, choice.acceleration_mm_s2});
  return choice;
}

Interpolator::Interpolator(double start_mm, double end_mm, const AxisLimits& limits)
    : start_mm_(start_mm),
      end_mm_(end_mm),
      sign_(end_mm < start_mm ? -1.0 : 1.0),
      x1_mm_(start_mm),
      x2_mm_(end_mm) {
  const double length_mm = std::abs(end_mm - start_mm);
  if (length_mm == 0.0) return;
  const TimeOptimalChoice choice = ChooseTimeOptimal(length_mm, limits);
  speed_mm_s_ = choice.speed_mm_s;
  acceleration_mm_s2_ = choice.acceleration_mm_s2;
  // Half of the distance at most: V^2 / 2 A of the short distance, except for rounding.
  const double ramp_mm =
      std::min(0.5 * speed_mm_s_ * speed_mm_s_ / acceleration_mm_s2_, 0.5 * length_mm);
  t1_s_ = speed_mm_s_ / acceleration_mm_s2_;
  t2_s_ = t1_s_ + (length_mm - 2.0 * ramp_mm) / speed_mm_s_;
  x1_mm_ = start_mm + sign_ * ramp_mm;
  x2_mm_ = end_mm - sign_ * ramp_mm;
}

AxisState Interpolator::At(double seconds) const {
  if (seconds < 0.0) return {start_mm_, 0.0, 0.0};
  if (seconds > t2_s_ + t1_s_) return {end_mm_, 0.0, 0.0};
  const double v = sign_ * speed_mm_s_;
  const double a = sign_ * acceleration_mm_s2_;
  if (seconds < t1_s_) {
    return {start_mm_ + 0.5 * a * seconds * seconds, a * seconds, a};
  }
  if (seconds < t2_s_) return {x1_mm_ + v * (seconds - t1_s_), v, 0.0};
  const double braking_s = seconds - t2_s_;
  return {x2_mm_ + v * braking_s - 0.5 * a * braking_s * braking_s, v - a * braking_s,
          -a};
}

}  // namespace intaglio::motion
