#pragma once

// How large a sudden temperature difference a glass withstands before it cracks.

namespace intaglio::optics {

struct ThermalProperties {
  double tensile_strength_mpa = 0;  ///< > 0
  double poisson_ratio = 0;         ///< -1..0.5, 0.16-0.3 for glasses
  double expansion_per_k = 0;       ///< linear, > 0
  double youngs_modulus_gpa = 0;    ///< > 0
};

/// How the difference comes about. The factors are the maximum that the source allows; it
/// compares local heating with thermal cracking by a beam.
enum class ThermalShock {
  kWholeBody,      ///< factor 1: equation (1) as printed
  kCooled,         ///< factor 1.5
  kHeatedLocally,  ///< factor 3
};

/// dT = sigma (1 - nu) / (alpha_T E), in kelvin, times the factor of the shock
/// (Trochimczuk 2008 ch. 5, eq. 1).
double ThermalStrengthK(const ThermalProperties& glass,
                        ThermalShock shock = ThermalShock::kWholeBody);

}  // namespace intaglio::optics
