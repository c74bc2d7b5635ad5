#pragma once

#include <assimp/Importer.hpp>
#include <functional>

#include "engrave/core/result.h"
#include "engrave/mesh/files/import_source.h"
#include "engrave/mesh/imported_mesh.h"

namespace intaglio::mesh {

/// Runs `read`, which calls the library's importer, welds the resulting mesh, and turns
/// every exception into an error. It holds the file's whole content twice.
Result<ImportedMesh> ImportByLibrary(const ImportSource& source,
                                     const std::function<void(Assimp::Importer&)>& read);

}  // namespace intaglio::mesh
