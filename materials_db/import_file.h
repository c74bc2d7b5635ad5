#pragma once

#include <filesystem>

#include "materials_db/import_result.h"

namespace intaglio::materials_db {

/// Reads a file of glasses by its ending: .agf, or .yml / .yaml of refractiveindex.info.
/// Every error names the file.
Imported ImportFile(const std::filesystem::path& file);

}  // namespace intaglio::materials_db
