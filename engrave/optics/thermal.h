#pragma once

// How large a sudden temperature difference a glass withstands before it cracks.

namespace intaglio::optics {

struct ThermalProperties {
  double tensile_strength_mpa = 0;  ///< > 0
  double poisson_ratio = 0;         ///< -1..0.5, 0.16-0.3 for glasses
  double expansion_per_k = 0;       ///< linear, > 0
  double youngs_modulus_gpa = 0;    ///< > 0
};

/// dT = sigma (1 - nu) / (alpha_T E), in kelvin (Trochimczuk 2008 ch. 5, eq. 1): of a
/// body that is heated as a whole. The source allows up to 1.5 times as much where it is
/// cooled, and 3 times where it is heated locally.
double ThermalStrengthK(const ThermalProperties& glass);

}  // namespace intaglio::optics
