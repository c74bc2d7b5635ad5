#pragma once

// Reads a model file, held in memory, by the readers of this folder: STL, OBJ, PLY, 3MF.
// import/mesh_import.h, which reads all formats, says what is done with a file.

#include <cstddef>
#include <span>
#include <string_view>

#include "engrave/core/result.h"
#include "engrave/mesh/files/import_source.h"
#include "engrave/mesh/imported_mesh.h"
#include "engrave/mesh/mesh_formats.h"

namespace intaglio::mesh {

/// Whether files of this extension, lower case, are read by the readers of this folder.
bool HasOwnReader(std::string_view extension);

/// What holds of a file of any format: kUnsupported unless its extension is one of
/// kMeshExtensions, kUnreadable when it is empty, kTooLarge.
Status CheckSource(const ImportSource& source, std::size_t byte_count);

/// Errors as those of ImportMeshFromMemory (import/mesh_import.h). Also kUnsupported: a
/// format that only the import library reads.
Result<ImportedMesh> ReadOwnFormat(std::span<const std::byte> bytes,
                                   std::string_view extension,
                                   const ImportOptions& options = {},
                                   std::string_view name = "model");

}  // namespace intaglio::mesh
