#pragma once

#include "materials_db/material.h"

namespace intaglio::materials_db {

/// A sound glass with every value known; none of the numbers is a round one, so that a
/// value that is lost or rounded shows.
inline Material CompleteGlass() {
  Material glass;
  glass.name = "Test-1";
  glass.manufacturer = "Glashütte & Söhne";
  glass.source = "line one, n < 2\n  line two: \"quoted\"";
  glass.dispersion = {.formula = optics::DispersionFormula::kSellmeier1,
                      .coefficients = {1.03961212, 0.00600069867, 0.231792344,
                                       0.0200179144, 1.01046945, 103.560653},
                      .min_wavelength_um = 0.3,
                      .max_wavelength_um = 2.5};
  glass.density_kg_m3 = 2510.1;
  glass.youngs_modulus_gpa = 82.3;
  glass.poisson_ratio = 0.2061;
  glass.tensile_strength_mpa = 41.7;
  glass.expansion_per_k = 7.13e-6;
  glass.specific_heat_j_kg_k = 858.3;
  glass.conductivity_w_m_k = 1.1143;
  glass.melting_point_c = 719.5;
  glass.bending_strength_mpa = 61.3;
  glass.compressive_strength_mpa = 903.1;
  glass.knoop_hardness_hk = 610.7;
  glass.impact_strength_kj_m2 = 1.85;
  glass.brittleness_per_sqrt_um = 7.1;
  glass.transmittance = {
      {0.5, 0.9942, 25.1}, {0.5461, 0.9961, 25.1}, {1.06, 0.9973, 10.3}};
  return glass;
}

}  // namespace intaglio::materials_db
