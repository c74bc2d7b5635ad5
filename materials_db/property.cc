#include "materials_db/property.h"

#include <array>

namespace intaglio::materials_db {
namespace {

constexpr std::array kRows = {
    PropertyRow{"density_kg_m3", "density", "kg/m3", &Properties::density_kg_m3, 500,
                20000},
    PropertyRow{"youngs_modulus_gpa", "Young's modulus", "GPa",
                &Properties::youngs_modulus_gpa, 0.1, 1300},
    PropertyRow{"poisson_ratio", "Poisson's ratio", "", &Properties::poisson_ratio, 0,
                0.5},
    PropertyRow{"tensile_strength_mpa", "tensile strength", "MPa",
                &Properties::tensile_strength_mpa, 1, 10000},
    PropertyRow{"expansion_per_k", "expansion", "1/K", &Properties::expansion_per_k,
                -2e-5, 2e-4},
    PropertyRow{"specific_heat_j_kg_k", "specific heat", "J/(kg K)",
                &Properties::specific_heat_j_kg_k, 50, 5000},
    PropertyRow{"conductivity_w_m_k", "conductivity", "W/(m K)",
                &Properties::conductivity_w_m_k, 0.05, 3000},
    PropertyRow{"melting_point_c", "melting or softening point", "C",
                &Properties::melting_point_c, 50, 4000},
    PropertyRow{"bending_strength_mpa", "bending strength", "MPa",
                &Properties::bending_strength_mpa, 1, 10000},
    PropertyRow{"compressive_strength_mpa", "compressive strength", "MPa",
                &Properties::compressive_strength_mpa, 1, 100000},
    PropertyRow{"knoop_hardness_hk", "Knoop hardness", "HK",
                &Properties::knoop_hardness_hk, 1, 10000},
    PropertyRow{"impact_strength_kj_m2", "impact strength", "kJ/m2",
                &Properties::impact_strength_kj_m2, 0.01, 1000},
    PropertyRow{"brittleness_per_sqrt_um", "brittleness", "1/sqrt(um)",
                &Properties::brittleness_per_sqrt_um, 0.01, 1000},
};

}  // namespace

std::span<const PropertyRow> PropertyRows() { return kRows; }

}  // namespace intaglio::materials_db
