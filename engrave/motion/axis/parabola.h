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

  double half_width_mm() const { return b_mm_; }
  double height_mm() const { return height_mm_; }
  double curvature_per_mm() const { return k_per_mm_; }  ///< k, half of the apex's

  double X3(double x5_mm) const;
  /// dx3 / dx5 = -2 k (x5 - b)
  double Slope(double x5_mm) const;

  /// (58): l = (1 / 2k) [2bk sqrt(1 + 4 b^2 k^2) + ln(2bk + sqrt(1 + 4 b^2 k^2))].
  double length_mm() const { return length_mm_; }
  /// Length of the arc from x5 = 0, 0 <= x5 <= 2 b; (47) with this upper end.
  double LengthTo(double x5_mm) const;
  /// The inverse: where the arc has this length, 0..l.
  double X5AtLength(double along_mm) const;

  /// On the parabola, `along_mm` from its start, at the speed V.
  ParabolaState At(double along_mm, double speed_mm_s) const;

 private:
  double HalfLength(double from_apex_mm) const;

  double b_mm_;
  double height_mm_;
  double k_per_mm_;
  double length_mm_ = 0.0;
};

/// The plant (38), (61), (70): x4' = alpha1 x4 + beta1 u4, x6' = alpha2 x6 + beta2 u6.
struct ParabolaPlant {
  double alpha1_per_s = 0.0;  ///< <= 0
  double alpha2_per_s = 0.0;  ///< <= 0
  double beta1_mm_s2_n = 1.0;
  double beta2_mm_s2_n = 1.0;
};

/// alpha1 = -b2 / (m2 + m3), beta1 = 1 / (m2 + m3), alpha2 = -b3 / m3, beta2 = 1 / m3
/// (corrected: alpha2 without its minus in print). Masses in kg > 0, viscous frictions
/// in N s / m >= 0, forces in N.
ParabolaPlant PlantOf(double m2_kg, double m3_kg, double b2_n_s_m, double b3_n_s_m);

/// Forces, N.
struct ParabolaControls {
  double u4_n = 0.0;
  double u6_n = 0.0;
};

/// The forces that hold the plant on the parabola while its speed changes by
/// `speed_rate_mm_s2` = dV/dt: (42) with 0, (54) with a, 0, -a of the trapezoid's arcs;
/// R1 = R2 = 0. The 2 x 2 system is solved directly; the closed forms (43), (56), (77),
/// (78) contain misprints. With m = -2 k (x5 - b):
///   beta1 u4 - m beta2 u6 = -alpha1 x4 - 2 k x6^2 + m alpha2 x6
///   m (alpha1 x4 + beta1 u4) + alpha2 x6 + beta2 u6 = dV/dt sqrt(1 + m^2)
/// The second is the printed one over x6, as x4 = m x6 and V = x6 sqrt(1 + m^2) on the
/// program: the same wherever the stage moves, and regular at rest, where the printed one
/// is singular. gamma is V dV/dt = a^2 t (corrected: 2 a^2 t in (55), (74)).
ParabolaControls ControlsFor(const Parabola& parabola, const ParabolaPlant& plant,
                             const ParabolaState& state, double speed_rate_mm_s2);

/// Ch. 6.2.5: only the parabola is held, (63), and of all such forces those of the least
/// J = beta1^2 u4^2 + u6^2 (64) are taken, (68): with P = 2 k beta2 (x5 - b) and
/// Q = -alpha1 x4 - 2 k x6^2 - 2 k (x5 - b) alpha2 x6,
///   u4 = Q / (beta1 (1 + P^2)),   u6 = Q P / (1 + P^2)
/// (corrected: alpha2 x4 in (63), (65) for alpha2 x6; the minus of u6 in (67)). J adds
/// squares of different units, as the source does; where P is large u4 all but vanishes
/// except round the apex, which a light stage is thrown around. What speed results is not
/// prescribed, so this is no program of a step.
ParabolaControls MinControlsFor(const Parabola& parabola, const ParabolaPlant& plant,
                                const ParabolaState& state);

}  // namespace intaglio::motion
