#pragma once

// One axis from rest to rest by ramp, cruise and ramp: the time-optimal choice of speed
// and acceleration, Trochimczuk 2008 ch. 6.2.6 (81)-(87), and the interpolator of the
// planar controller, ch. 6.6.2 (99)-(104), which is that course as a function of time.
// mm, mm/s, mm/s^2, s.
//
// What is the same in the source: (81) is the trapezoid's (12)-(14), and (51) along the
// parabola; (85) is the triangle's (15). (84) therefore gives the same as
// StopAndGoSeconds, and the interpolator with V_M, A_M of (86) is the time-optimal
// course. Both differ from the profiles triangle, trapezoid and mix: those stretch the
// course over whole ticks, while here the axis moves at its limits and then waits. As
// programs they differ from each other in whether the axes share one course
// (interpolator_program.h).

#include "engrave/motion/axis/profile.h"

namespace intaglio::motion {

/// (86): the speed and the acceleration of the minimum time, and that time.
struct TimeOptimalChoice {
  double speed_mm_s = 0.0;
  double acceleration_mm_s2 = 0.0;
  double seconds = 0.0;
};

/// For a way of `length_mm` > 0 with V <= V0 and a <= a0, which are `limits`:
///   (83)  dT/dV = -l / V^2 + 1 / a0 = 0   (corrected: the minus is missing in print)
///   (84)  V = min(sqrt(l a0), V0), a = a0;   (81)  T = l / V + V / a.
TimeOptimalChoice ChooseTimeOptimal(double length_mm, const AxisLimits& limits);

/// Position and speed of the axis.
struct AxisState {
  double position_mm = 0.0;
  double speed_mm_s = 0.0;
  double acceleration_mm_s2 = 0.0;
};

/// (99)-(104), in either direction. At the start and the end the acceleration is the
/// ramp's, at T1 and T2 the later arc's.
class Interpolator {
 public:
  /// From X_B to X_E with V_M and A_M of `limits`. A way too short to reach V_M, shorter
  /// than V_M^2 / A_M, gets V_M by (84), and X1 = X2 is its middle.
  Interpolator(double start_mm, double end_mm, const AxisLimits& limits);

  /// `seconds` after the start; before 0 and after the end: at rest there.
  ///   X_B..X1   X_B + A t^2 / 2
  ///   X1..X2    X1 + V (t - T1)
  ///   X2..X_E   X2 + V (t - T2) - A (t - T2)^2 / 2   (corrected: the square is missing)
  AxisState At(double seconds) const;

 private:
  double start_mm_;
  double end_mm_;
  double sign_;              ///< of the direction
  double speed_mm_s_ = 0.0;  ///< V_M, without a sign
  double acceleration_mm_s2_ = 0.0;
  double t1_s_ = 0.0;  ///< T1, end of the ramp
  double t2_s_ = 0.0;  ///< T2, end of the cruise
  double x1_mm_;       ///< X1, the place at T1
  double x2_mm_;       ///< X2, the place at T2
};

}  // namespace intaglio::motion
