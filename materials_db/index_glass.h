#pragma once

// A glass of which only the refractive index is known: the name "n=1.52" is that glass,
// wherever a glass is named.

#include <optional>
#include <string>
#include <string_view>

#include "engrave/core/result.h"
#include "materials_db/material.h"

namespace intaglio::materials_db {

/// "n=1.52".
std::string NameOfIndexGlass(double refractive_index);

/// The glass of such a name: its index is the same at all wavelengths, 0.2..10 um, and
/// nothing else is known. nullopt: another name. kInvalidValue: no number, 1..4.
std::optional<Result<Material>> IndexGlass(std::string_view name);

}  // namespace intaglio::materials_db
