#pragma once

#include <span>
#include <string>

#include "materials_db/material.h"

namespace intaglio::materials_db {

/// Glasses as records of refractiveindex.info, one YAML document each, which ImportRii
/// reads back as equal. Values for which the site's records have no field are under
/// INTAGLIO, each under its name of property.h; a formula of AGF catalogs has the type
/// "agf formula N".
std::string ExportRii(std::span<const Material> materials);

}  // namespace intaglio::materials_db
