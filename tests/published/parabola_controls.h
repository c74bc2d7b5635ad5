#pragma once

// The published plant of the parabola and the forces that drive it along, Trochimczuk
// 2008 ch. 6.2.3-6.2.6 (37)-(78). Motion controllers take positions and velocities, not
// forces, so no planner uses these: they are for the design of a drive, and the tests
// show that a plant under the forces passes the states that Parabola computes, with which
// they share no code. mm, s, N, kg.

#include <Eigen/Dense>
#include <cmath>

#include "engrave/motion/axis/parabola.h"

namespace intaglio::motion {

/// x3 = h - k (x5 - b)^2, h = k b^2, as printed.
struct PrintedParabola {
  double b_mm = 1.0;
  double h_mm = 0.0;

  double k_per_mm() const { return h_mm / (b_mm * b_mm); }
  double Slope(double x5_mm) const { return -2.0 * k_per_mm() * (x5_mm - b_mm); }
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
inline ParabolaPlant PlantOf(double m2_kg, double m3_kg, double b2_n_s_m,
                             double b3_n_s_m) {
  constexpr double kMmPerM = 1000.0;
  return {-b2_n_s_m / (m2_kg + m3_kg), -b3_n_s_m / m3_kg, kMmPerM / (m2_kg + m3_kg),
          kMmPerM / m3_kg};
}

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
inline ParabolaControls ControlsFor(const PrintedParabola& parabola,
                                    const ParabolaPlant& plant,
                                    const ParabolaState& state, double speed_rate_mm_s2) {
  const double m = parabola.Slope(state.x5_mm);
  const double k = parabola.k_per_mm();
  const double drag4 = plant.alpha1_per_s * state.x4_mm_s;
  const double drag6 = plant.alpha2_per_s * state.x6_mm_s;
  Eigen::Matrix2d matrix;
  matrix << plant.beta1_mm_s2_n, -m * plant.beta2_mm_s2_n,  //
      m * plant.beta1_mm_s2_n, plant.beta2_mm_s2_n;
  const Eigen::Vector2d right(
      -drag4 - 2.0 * k * state.x6_mm_s * state.x6_mm_s + m * drag6,
      speed_rate_mm_s2 * std::sqrt(1.0 + m * m) - m * drag4 - drag6);
  const Eigen::Vector2d u = matrix.partialPivLu().solve(right);
  return {u.x(), u.y()};
}

/// Ch. 6.2.5: only the parabola is held, (63), and of all such forces those of the least
/// J = beta1^2 u4^2 + u6^2 (64) are taken, (68): with P = 2 k beta2 (x5 - b) and
/// Q = -alpha1 x4 - 2 k x6^2 - 2 k (x5 - b) alpha2 x6,
///   u4 = Q / (beta1 (1 + P^2)),   u6 = Q P / (1 + P^2)
/// (corrected: alpha2 x4 in (63), (65) for alpha2 x6; the minus of u6 in (67)). J adds
/// squares of different units, as the source does; where P is large u4 all but vanishes
/// except round the apex, which a light stage is thrown around. What speed results is not
/// prescribed, so this is no program of a step.
inline ParabolaControls MinControlsFor(const PrintedParabola& parabola,
                                       const ParabolaPlant& plant,
                                       const ParabolaState& state) {
  const double m = parabola.Slope(state.x5_mm);
  const double k = parabola.k_per_mm();
  const double p = -m * plant.beta2_mm_s2_n;
  const double q = -plant.alpha1_per_s * state.x4_mm_s -
                   2.0 * k * state.x6_mm_s * state.x6_mm_s +
                   m * plant.alpha2_per_s * state.x6_mm_s;
  const double share = q / (1.0 + p * p);
  return {share / plant.beta1_mm_s2_n, share * p};
}

}  // namespace intaglio::motion
