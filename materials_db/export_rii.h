#pragma once

#include <span>
#include <string>

#include "materials_db/material.h"

namespace intaglio::materials_db {

/// Glasses as records of refractiveindex.info, one YAML document each, which ImportRii
/// reads back as equal. What the site's records have no place for stands under INTAGLIO,
/// each value under its name of property.h; a formula of AGF catalogs has the type "agf
/// formula N".
std::string ExportRii(std::span<const Material> materials);

}  // namespace intaglio::materials_db
