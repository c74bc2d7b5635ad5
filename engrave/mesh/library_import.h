#pragma once

#include <assimp/Importer.hpp>
#include <functional>

#include "engrave/core/result.h"
#include "engrave/mesh/import_source.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::mesh {

/// Runs `read`, which lets the library's importer read, welds what it read, and turns
/// whatever is thrown into an error. It holds the file's whole content twice over.
Result<TriangleMesh> ImportByLibrary(const ImportSource& source,
                                     const std::function<void(Assimp::Importer&)>& read);

}  // namespace intaglio::mesh
