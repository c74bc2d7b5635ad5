#pragma once

// Motion along a parabola, Trochimczuk 2008 ch. 6.2.3-6.2.6 (37)-(60), in its plane:
//   x3 = h - k (x5 - b)^2,   x4 = x3', x6 = x5',   h = k b^2
// so it joins x5 = 0 with x5 = 2 b, at x3 = 0 both, and rises by h in between. mm, s.
//
// The speed along it is a law V(t):
//   6.2.3  constant, (37). From rest nothing can follow it; it is the middle arc of
//   6.2.4  the trapezoid (45), (57): t_1 = V1 / a, time (51) tau = l / V1 + V1 / a,
//          braking V = a (tau - t)   (corrected: a (t - tau) in print)
//   6.2.6  the trapezoid with the V and a of the least time, (81)-(87).
// The way along the arc is therefore an Interpolator from 0 to l.

#include "engrave/motion/axis/interpolator.h"

namespace intaglio::motion {

/// State in the parabola's plane, mm and mm/s.
struct ParabolaState {
  double x3_mm = 0.0;
  double x4_mm_s = 0.0;
  double x5_mm = 0.0;
  double x6_mm_s = 0.0;
};

class Parabola {
 public:
  /// half_width_mm: b > 0; height_mm: h >= 0, where 0 is the straight line.
  Parabola(double half_width_mm, double height_mm);

  double X3(double x5_mm) const;
  /// dx3 / dx5 = -2 k (x5 - b)
  double Slope(double x5_mm) const;

  /// (58): l = (1 / 2k) [2bk sqrt(1 + 4 b^2 k^2) + ln(2bk + sqrt(1 + 4 b^2 k^2))].
  double length_mm() const { return length_mm_; }
  /// Where the arc from x5 = 0 has this length, 0..l: the inverse of (47) with the upper
  /// end x5.
  double X5AtLength(double along_mm) const;

  /// On the parabola, `along_mm` from its start, at the speed V.
  ParabolaState At(double along_mm, double speed_mm_s) const;

 private:
  double HalfLength(double from_apex_mm) const;

  double b_mm_;
  double k_per_mm_;  ///< k, half of the curvature at the apex
  double length_mm_ = 0.0;
};

}  // namespace intaglio::motion
