#pragma once

// Reads a 3MF package (3MF core specification 1.3): the items of the build with their
// components and transforms, across all model parts of the package (production extension,
// p:path), in mm by the unit that the model declares. Objects of the type "support" are
// left out, as no part of the model.
//
// What would change the shape and is not read is refused by name: beam lattices, and
// every extension that the file requires but materials, triangle sets and production.

#include <string_view>

#include "engrave/core/result.h"
#include "engrave/mesh/files/import_source.h"
#include "engrave/mesh/imported_mesh.h"

namespace intaglio::mesh {

/// Errors as ImportMeshFromMemory() has them.
Result<ImportedMesh> ReadThreeMf(std::string_view archive, const ImportSource& source);

}  // namespace intaglio::mesh
