#pragma once

// Meshes are read by a process of their own. The library that reads all formats but STL
// trusts its files (services/job/reading/file_process.h).

#include <chrono>
#include <filesystem>

#include "engrave/mesh/mesh_formats.h"

namespace intaglio::mesh_reader {

struct ReadingProcess {
  std::filesystem::path program;  ///< intaglio-mesh-reader
  /// Processor time, of a file of no size; a second more for every 4 MB of it. Large
  /// meshes take a tenth of that.
  std::chrono::seconds time{20};
};

/// Gives the same meshes and errors as mesh::ImportMeshFromMemory, and reads an STL in
/// this process by itself. Further errors: kNotFound (no such program), kUnreadable (the
/// process broke down), kTooLarge (it took too long), kIo. Of any thread.
mesh::MeshReader ReadBy(const ReadingProcess& process);

}  // namespace intaglio::mesh_reader
