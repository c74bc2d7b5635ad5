#include "engrave/motion/axis/profile.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::motion {

double TriangleSeconds(double distance_mm, double acceleration_mm_s2) {
  return 2.0 * std::sqrt(distance_mm / acceleration_mm_s2);
}

double TrapezoidSeconds(double distance_mm, const AxisLimits& limits) {
  return distance_mm / limits.max_speed_mm_s +
         limits.max_speed_mm_s / limits.max_acceleration_mm_s2;
}

double SwitchingSeconds(double duration_s, double distance_mm,
                        double acceleration_mm_s2) {
  // The lesser root of t (T - t) = s / a, as product over greater root: the printed
  // difference loses its digits when the ramp is short.
  const double half_s = 0.5 * duration_s;
  const double product_s2 = distance_mm / acceleration_mm_s2;
  const double root_s = std::sqrt(std::max(0.0, half_s * half_s - product_s2));
  return product_s2 > 0.0 ? product_s2 / (half_s + root_s) : 0.0;
}

double CubicSeconds(double distance_mm, const AxisLimits& limits) {
  return std::max(std::sqrt(6.0 * distance_mm / limits.max_acceleration_mm_s2),
                  1.5 * distance_mm / limits.max_speed_mm_s);
}

double StopAndGoSeconds(double distance_mm, const AxisLimits& limits) {
  const double peak_mm_s = std::sqrt(distance_mm * limits.max_acceleration_mm_s2);
  return peak_mm_s <= limits.max_speed_mm_s
             ? TriangleSeconds(distance_mm, limits.max_acceleration_mm_s2)
             : TrapezoidSeconds(distance_mm, limits);
}

double MinSeconds(Profile profile, double distance_mm, const AxisLimits& limits) {
  switch (profile) {
    case Profile::kTriangle:
      return std::max(TriangleSeconds(distance_mm, limits.max_acceleration_mm_s2),
                      2.0 * distance_mm / limits.max_speed_mm_s);
    case Profile::kCubic:
      return CubicSeconds(distance_mm, limits);
    case Profile::kTrapezoid:
    case Profile::kMix:
    case Profile::kTimeOptimal:
    case Profile::kInterpolator:
      break;
    case Profile::kParabola:
    case Profile::kLq:
      Require(false, "profile {} has no formula of its time", static_cast<int>(profile));
  }
  return StopAndGoSeconds(distance_mm, limits);
}

AxisLimits UnitStepLimits(const Vec3& step_mm, const Limits& limits) {
  const auto length = step_mm.cwiseAbs().array();
  const double whole_mm = step_mm.norm();
  return {1.0 / std::max((length / limits.max_speed_mm_s.array()).maxCoeff(),
                         whole_mm / limits.max_speed_norm_mm_s),
          1.0 / std::max((length / limits.max_acceleration_mm_s2.array()).maxCoeff(),
                         whole_mm / limits.max_acceleration_norm_mm_s2)};
}

std::uint64_t WholeTicks(double seconds, double rate_hz) {
  const double ticks = seconds * rate_hz * (1.0 - kTickSlackRatio);
  Require(ticks < 9e15, "a time of {} s at {} Hz is no count of ticks", seconds, rate_hz);
  // Rounded up; std::ceil is a call.
  const auto whole = static_cast<std::int64_t>(ticks);
  const std::int64_t up = whole + (static_cast<double>(whole) < ticks ? 1 : 0);
  return static_cast<std::uint64_t>(std::max<std::int64_t>(1, up));
}

}  // namespace intaglio::motion
