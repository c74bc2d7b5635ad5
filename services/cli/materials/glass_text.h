#pragma once

// Glasses as text: tables for people, JSON for programs. A glass in JSON is an object of
// two messages as report.json has them, "material" (MaterialRecord) and "optics"
// (OpticalValuesRecord), and of "focus" (PulseFocusRecord) where a machine is known.

#include <optional>
#include <span>
#include <string>

#include "materials_db/material.h"
#include "materials_db/material_store.h"
#include "proto/material.pb.h"

namespace intaglio::cli {

/// What the optical values are computed for.
struct PrintedLight {
  double wavelength_nm = 532;
  double numerical_aperture = 0.1;  ///< of the lens, in air
};

/// One glass a line below a line of titles, with its aliases at the end; "-" where a
/// value is unknown or the glass does not hold for the wavelength.
std::string GlassesAsTable(std::span<const materials_db::Material> materials,
                           std::span<const materials_db::GlassAlias> aliases,
                           const PrintedLight& light);
/// An array of GlassAsJson, one a line.
std::string GlassesAsJson(std::span<const materials_db::Material> materials,
                          const PrintedLight& light);

/// All that is kept of one glass, with the sources of its aliases.
std::string GlassAsTable(const materials_db::Material& material,
                         std::span<const materials_db::GlassAlias> aliases);
/// All that is computed of it.
std::string OpticsAsTable(const materials_db::OpticalValues& optics,
                          const PrintedLight& light);
/// What a pulse of the machine does at the focus.
std::string FocusAsTable(const PulseFocusRecord& focus);
/// Glass and optics, and the focus where it is given; "optics" is absent where it cannot
/// be computed.
std::string GlassAsJson(const materials_db::Material& material, const PrintedLight& light,
                        const std::optional<PulseFocusRecord>& focus = {});

}  // namespace intaglio::cli
