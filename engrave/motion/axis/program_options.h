#pragma once

// What the programs of a step leave open in the source (Trochimczuk 2008 ch. 6.2.3-6.2.7)
// and a job may set.

#include <optional>

namespace intaglio::motion {

/// An axis as in (38), driven by a force F: m v' + b v = F, and the weights of (88):
/// the integral of force_weight F^2 + speed_weight v^2 becomes a minimum.
struct LqPlant {
  double moving_mass_kg = 1;  ///< m > 0
  double friction_n_s_m = 0;  ///< b >= 0, viscous
  double speed_weight = 0;    ///< of (mm/s)^2, >= 0
  double force_weight = 1;    ///< of N^2, > 0
};

/// The rate w of lq_program.h that such a plant has, 1/s. With u = v' = alpha v + beta F,
/// alpha = -b / m, beta = 1 / m, the cross term alpha v v' of F^2 has no integral between
/// two rests, so that what is left is (r / beta^2) (u^2 + w^2 v^2) with
///   w^2 = (q / r) beta^2 + alpha^2.
double LqRatePerS(const LqPlant& plant);

struct ProgramOptions {
  /// h of the parabola, >= 0, at most half of a step; absent: a tenth of the step and 1
  /// mm at most.
  std::optional<double> parabola_height_mm;
  /// Absent: w follows from the limits of the step.
  std::optional<LqPlant> lq;
};

}  // namespace intaglio::motion
