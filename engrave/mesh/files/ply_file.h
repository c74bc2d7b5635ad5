#pragma once

// Reads a PLY (Turk 1994) with faces: polygons (vertex_indices, vertex_index) and
// triangle strips, whose parts are divided by -1. Other properties are read past, as are
// elements of the look of a model; all others are findings. A grid of ranges (range_grid)
// and vertices without x, y or z are refused by name.

#include <string_view>

#include "engrave/core/result.h"
#include "engrave/mesh/files/import_source.h"
#include "engrave/mesh/imported_mesh.h"

namespace intaglio::mesh {

/// Errors as ImportMeshFromMemory() has them. The header must have passed CheckPlyHeader.
Result<ImportedMesh> ReadPly(std::string_view file, const ImportSource& source);

}  // namespace intaglio::mesh
