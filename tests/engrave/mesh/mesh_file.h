#pragma once

// Model files as the product reads them: whole, then from memory.

#include <filesystem>
#include <span>

#include "engrave/io/whole_file.h"
#include "engrave/mesh/import/mesh_import.h"

namespace intaglio::mesh {

inline Result<ImportedMesh> ImportMesh(const std::filesystem::path& file) {
  const auto bytes = io::ReadWholeFile(file, ImportOptions().max_file_bytes);
  if (!bytes) return tl::unexpected(bytes.error());
  return ImportMeshFromMemory(std::as_bytes(std::span(*bytes)), file.extension().string(),
                              {}, file.string());
}

}  // namespace intaglio::mesh
