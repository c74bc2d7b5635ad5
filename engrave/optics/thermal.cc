#include "engrave/optics/thermal.h"

#include "engrave/core/check.h"

namespace intaglio::optics {
namespace {

constexpr double kMpaPerGpa = 1000;

}  // namespace

double ThermalLoadFactor(ThermalLoad load) {
  switch (load) {
    case ThermalLoad::kWholeBody:
      return 1;
    case ThermalLoad::kCooling:
      return 1.5;
    case ThermalLoad::kLocalHeating:
      return 3;
  }
  throw PreconditionError("a thermal load of no kind");
}

double ThermalStrengthK(const ThermalProperties& glass, ThermalLoad load) {
  Require(glass.tensile_strength_mpa > 0 && glass.expansion_per_k > 0 &&
              glass.youngs_modulus_gpa > 0,
          "strength {} MPa, expansion {} 1/K and Young's modulus {} GPa must be positive",
          glass.tensile_strength_mpa, glass.expansion_per_k, glass.youngs_modulus_gpa);
  Require(glass.poisson_ratio >= -1 && glass.poisson_ratio <= 0.5,
          "poisson_ratio must be in -1..0.5, is {}", glass.poisson_ratio);
  return ThermalLoadFactor(load) * glass.tensile_strength_mpa *
         (1 - glass.poisson_ratio) /
         (glass.expansion_per_k * glass.youngs_modulus_gpa * kMpaPerGpa);
}

}  // namespace intaglio::optics
