#pragma once

// A glass of the material base, and what light and heat do in it.

#include <optional>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/optics/absorption.h"
#include "engrave/optics/dispersion.h"
#include "materials_db/property.h"

namespace intaglio::materials_db {

/// Text is UTF-8. The properties are members of their own: material.density_kg_m3.
struct Material : Properties {
  /// The key; upper and lower case (of ASCII) are the same glass. 1..80 characters, no
  /// control characters, no space at its ends.
  std::string name;
  std::string manufacturer;  ///< may be empty; at most 200 bytes, one line
  /// Where the values come from, for people; at most 16 KiB, lines end in '\n'.
  std::string source;
  optics::Dispersion dispersion;
  /// By ascending wavelength, each once; empty: unknown. At most 1000 entries.
  std::vector<optics::Transmittance> transmittance;

  bool operator==(const Material&) const = default;
};

/// All errors of a material. Each message begins with the field's name and gives the
/// allowed range; empty when the material is valid. A valid glass has an index at the
/// ends and in the middle of its wavelength range.
std::vector<Error> CheckMaterial(const Material& material);

/// The values a job is made with.
struct OpticalValues {
  double refractive_index = 0;        ///< >= 1
  std::optional<double> abbe_number;  ///< unknown when the range misses a line of it
  double reflectance_ratio = 0;       ///< Fresnel, normal incidence, the top face, 0..1
  double stage_per_glass_ratio = 0;   ///< stage move for a focus move in the glass, 0..1
  double cone_tangent = 0;            ///< of the beam's half angle in the glass
  /// Sudden temperature difference that the whole body withstands; unknown when one of
  /// its values is (strength, Poisson's ratio, expansion > 0, Young's modulus).
  std::optional<double> thermal_strength_k;
  /// The same where it is heated in a small place, as by a laser: 3 times as much.
  std::optional<double> local_thermal_strength_k;
  /// a of exp(-a z); unknown without transmittance about this wavelength.
  std::optional<double> absorption_per_mm;
};

/// Fails for a numerical aperture outside (0, 1) and for a wavelength outside the
/// glass's range; the message names the glass.
Result<OpticalValues> ComputeOptics(const Material& material, double wavelength_nm,
                                    double numerical_aperture);

}  // namespace intaglio::materials_db
