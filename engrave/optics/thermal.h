#pragma once

// How large a sudden temperature difference a glass withstands before it cracks.

namespace intaglio::optics {

struct ThermalProperties {
  double tensile_strength_mpa = 0;  ///< > 0
  double poisson_ratio = 0;         ///< -1..0.5, 0.16-0.3 for glasses
  double expansion_per_k = 0;       ///< linear, > 0
  double youngs_modulus_gpa = 0;    ///< > 0
};

/// Where the temperature changes, and with that how much of it the glass withstands.
enum class ThermalLoad {
  kWholeBody,     ///< 1: of a body that is heated as a whole
  kCooling,       ///< 1.5, "up to": where it is cooled
  kLocalHeating,  ///< 3, "up to": where it is heated in a small place, as at a focus
};

/// The factor of a load, without unit (Trochimczuk 2008 ch. 5.2).
double ThermalLoadFactor(ThermalLoad load);

/// dT = factor sigma (1 - nu) / (alpha_T E), in kelvin (Trochimczuk 2008 ch. 5.2, eq. 1,
/// where the factor is 1).
double ThermalStrengthK(const ThermalProperties& glass,
                        ThermalLoad load = ThermalLoad::kWholeBody);

}  // namespace intaglio::optics
