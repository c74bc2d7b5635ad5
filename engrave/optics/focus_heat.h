#pragma once

// The heat of a pulse about its focus, by conduction, and how fast its crack grows
// (Trochimczuk 2008 ch. 5.2: a crack forms where the glass is heated above its thermal
// strength and stays below its melting point; it grows at 50 to 60 % of the speed of
// transverse waves, which is 2 km/s in glass).
//
// The source gives the condition and no formula. Here the heat is released at a point and
// at once, for both is small beside the crack: in 12 ns heat goes 0.2 um, and the spot is
// tens of um wide. Then the rise of temperature at a distance r after a time t is that of
// Carslaw and Jaeger 1959, ch. 10.2. Doubts: heat capacity and conductivity are those at
// room temperature, latent heat is not regarded, and what share of a pulse becomes heat
// is taken from a measured crack (crack_model.h).

namespace intaglio::optics {

/// All > 0.
struct ConductingProperties {
  double density_kg_m3 = 0;
  double specific_heat_j_kg_k = 0;
  double conductivity_w_m_k = 0;
};

/// Conductivity by heat capacity, mm^2/s; about 0.5 for glasses.
double DiffusivityMm2S(const ConductingProperties& glass);

/// Rise above the temperature before the pulse, K, at `distance_mm` >= 0 of its focus,
/// `seconds` > 0 after it has left `heat_mj` >= 0 there.
double TemperatureRiseK(const ConductingProperties& glass, double heat_mj,
                        double distance_mm, double seconds);

/// The radius, mm, within which the rise exceeds `rise_k` > 0 at some time. It does not
/// depend on the conductivity, which decides when. heat_mj >= 0.
double HeatedRadiusMm(const ConductingProperties& glass, double heat_mj, double rise_k);

/// Until the heat has spread beyond a sphere of this radius (> 0): r^2 / (4 a), s.
double CoolingSeconds(const ConductingProperties& glass, double radius_mm);

/// Speed of transverse waves, sqrt(G / rho) with G = E / (2 (1 + nu)), m/s.
double TransverseWaveSpeedMS(double youngs_modulus_gpa, double poisson_ratio,
                             double density_kg_m3);

/// The longest time that a crack of this length takes to grow from its middle, s: at half
/// the speed of transverse waves, the slow end of the source's second stage. All > 0.
double CrackGrowthSeconds(double length_mm, double transverse_wave_speed_m_s);

}  // namespace intaglio::optics
