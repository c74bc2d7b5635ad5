#pragma once

// The mechanical and thermal properties a glass may have, as one table: their names are
// the same in C++, SQL, YAML and proto, and every reader and writer walks the table.

#include <optional>
#include <span>

namespace intaglio::materials_db {

/// Any of them may be unknown.
struct Properties {
  std::optional<double> density_kg_m3;
  std::optional<double> youngs_modulus_gpa;
  std::optional<double> poisson_ratio;
  std::optional<double> tensile_strength_mpa;
  /// Linear, at room temperature (-30..70 C as a rule). Some glasses shrink: negative.
  std::optional<double> expansion_per_k;
  std::optional<double> specific_heat_j_kg_k;
  std::optional<double> conductivity_w_m_k;
  /// A glass has no sharp melting point: for one it is the softening point, the
  /// temperature of viscosity 10^7.6 dPa s.
  std::optional<double> melting_point_c;
  /// The strengths of glass depend on its surface more than on its composition.
  std::optional<double> bending_strength_mpa;
  std::optional<double> compressive_strength_mpa;
  /// Knoop hardness, kgf/mm^2 under 0.98 N for 20 s (HK 0.1/20).
  std::optional<double> knoop_hardness_hk;
  /// Energy of a blow that breaks a rod, by its cross section (Charpy).
  std::optional<double> impact_strength_kj_m2;
  /// Hardness by fracture toughness, H / K_Ic, 1/sqrt(um): 6 to 9 for glasses (Lawn and
  /// Marshall 1979). Above it grows a crack where a metal would flow.
  std::optional<double> brittleness_per_sqrt_um;

  bool operator==(const Properties&) const = default;
};

struct PropertyRow {
  const char* name;   ///< as the member, e.g. "density_kg_m3"
  const char* title;  ///< for people, e.g. "density"
  const char* unit;   ///< for people, e.g. "kg/m3"; empty for a ratio
  std::optional<double> Properties::*value;
  /// The allowed range, ends included. Wide enough for every transparent solid; a value
  /// outside is in a wrong unit (g/cm3, MPa for GPa, 1e-6/K).
  double min;
  double max;
};

/// All properties, in the order in which they are shown.
std::span<const PropertyRow> PropertyRows();

}  // namespace intaglio::materials_db
