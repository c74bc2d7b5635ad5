#pragma once

// Reads a Wavefront OBJ (Wavefront Advanced Visualizer manual, appendix B1): vertices (v)
// and faces (f) with indices from the beginning or, negative, from the end; in double.
// The object of a face is the last o or g before it, up to its first blank. Points,
// lines, texture coordinates, normals and materials are left out.
//
// Free-form curves and surfaces are refused by name, as is what no OBJ has.

#include <string_view>

#include "engrave/core/result.h"
#include "engrave/mesh/files/import_source.h"
#include "engrave/mesh/imported_mesh.h"

namespace intaglio::mesh {

/// Errors as ImportMeshFromMemory() has them; those of the text name the line.
Result<ImportedMesh> ReadObj(std::string_view text, const ImportSource& source);

}  // namespace intaglio::mesh
