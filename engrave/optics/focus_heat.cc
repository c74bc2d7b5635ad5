// The rise after an instantaneous release of the heat Q at a point of a body without
// bounds (Carslaw and Jaeger 1959, ch. 10.2), with a = k / (rho c):
//   v(r, t) = Q / (rho c (4 pi a t)^(3/2)) exp(-r^2 / (4 a t)).
// dv/dt = 0 at t = r^2 / (6 a), so the largest rise at r is
//   v_max(r) = Q / (rho c r^3) (3 / (2 pi e))^(3/2),
// without a. The Gaussian falls to 1/e at r = sqrt(4 a t).

#include "engrave/optics/focus_heat.h"

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"

namespace intaglio::optics {
namespace {

using std::numbers::pi;

constexpr double kJPerMj = 1e-3;
constexpr double kMm3PerM3OfHeat = 1e9;
constexpr double kMm2PerM2OfHeat = 1e6;
constexpr double kPaPerGPa = 1e9;
constexpr double kSlowShareOfWaves = 0.5;

/// J/(mm^3 K)
double HeatCapacity(const ConductingProperties& glass) {
  Require(glass.density_kg_m3 > 0 && glass.specific_heat_j_kg_k > 0 &&
              glass.conductivity_w_m_k > 0,
          "density {} kg/m3, specific heat {} J/(kg K) and conductivity {} W/(m K) must "
          "be positive",
          glass.density_kg_m3, glass.specific_heat_j_kg_k, glass.conductivity_w_m_k);
  return glass.density_kg_m3 * glass.specific_heat_j_kg_k / kMm3PerM3OfHeat;
}

}  // namespace

double DiffusivityMm2S(const ConductingProperties& glass) {
  (void)HeatCapacity(glass);
  return glass.conductivity_w_m_k / (glass.density_kg_m3 * glass.specific_heat_j_kg_k) *
         kMm2PerM2OfHeat;
}

double TemperatureRiseK(const ConductingProperties& glass, double heat_mj,
                        double distance_mm, double seconds) {
  Require(heat_mj >= 0 && distance_mm >= 0 && seconds > 0,
          "heat {} mJ and distance {} mm must not be negative, the time {} s positive",
          heat_mj, distance_mm, seconds);
  const double spread_mm2 = 4 * DiffusivityMm2S(glass) * seconds;
  return heat_mj * kJPerMj / HeatCapacity(glass) / std::pow(pi * spread_mm2, 1.5) *
         std::exp(-distance_mm * distance_mm / spread_mm2);
}

double HeatedRadiusMm(const ConductingProperties& glass, double heat_mj, double rise_k) {
  Require(heat_mj >= 0 && rise_k > 0,
          "heat {} mJ must not be negative, the rise {} K positive", heat_mj, rise_k);
  return std::cbrt(heat_mj * kJPerMj / (HeatCapacity(glass) * rise_k)) *
         std::sqrt(3 / (2 * pi * std::numbers::e));
}

double CoolingSeconds(const ConductingProperties& glass, double radius_mm) {
  Require(radius_mm > 0, "radius_mm must be positive, is {}", radius_mm);
  return radius_mm * radius_mm / (4 * DiffusivityMm2S(glass));
}

double TransverseWaveSpeedMS(double youngs_modulus_gpa, double poisson_ratio,
                             double density_kg_m3) {
  Require(youngs_modulus_gpa > 0 && poisson_ratio > -1 && density_kg_m3 > 0,
          "Young's modulus {} GPa and density {} kg/m3 must be positive, Poisson's ratio "
          "{} above -1",
          youngs_modulus_gpa, density_kg_m3, poisson_ratio);
  const double shear_modulus_pa =
      youngs_modulus_gpa * kPaPerGPa / (2 * (1 + poisson_ratio));
  return std::sqrt(shear_modulus_pa / density_kg_m3);
}

double CrackGrowthSeconds(double length_mm, double transverse_wave_speed_m_s) {
  Require(length_mm > 0 && transverse_wave_speed_m_s > 0,
          "length {} mm and wave speed {} m/s must be positive", length_mm,
          transverse_wave_speed_m_s);
  return length_mm / 2 / 1000 / (kSlowShareOfWaves * transverse_wave_speed_m_s);
}

}  // namespace intaglio::optics
