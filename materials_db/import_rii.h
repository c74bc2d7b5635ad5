#pragma once

// Records of refractiveindex.info (YAML): DATA with formula 1-9, wavelength_range and
// coefficients; REFERENCES and COMMENTS become the source; of PROPERTIES density, thermal
// expansion (near room temperature) and nd, against which the formula is checked. What
// ExportRii adds is read too. Several YAML documents in one file are several glasses.

#include <cstddef>
#include <string_view>

#include "materials_db/import_result.h"

namespace intaglio::materials_db {

/// A record has some kilobytes; a parsed YAML takes a hundred times its size in memory.
inline constexpr std::size_t kMaxRiiBytes = 4 * 1024 * 1024;

/// `name` is used for a record without a name of its own. The site's records never have
/// one: their file name is the name of the glass.
Imported ImportRii(std::string_view yaml, std::string_view name);

}  // namespace intaglio::materials_db
