#pragma once

// Meshes that stay in memory after they were read, for a command that needs those of the
// same files several times: for the size of its block, a draft, the points.

#include <cstddef>
#include <string>
#include <vector>

#include "engrave/mesh/mesh_formats.h"

namespace intaglio {

class KeptMeshes {
 public:
  /// Larger files are read each time: their meshes would fill the memory.
  static constexpr std::size_t kMaxFileBytes = std::size_t{256} << 20;

  /// Gives what `read` gives. A file of the same name, bytes and objects is read once;
  /// each further call gets a copy of its mesh. Errors are not kept. The result is used
  /// by one thread, while this lives.
  mesh::MeshReader Around(mesh::MeshReader read);

 private:
  struct Kept {
    std::string name;
    std::vector<std::string> objects;
    std::size_t byte_count = 0, hash = 0;
    mesh::ImportedMesh mesh;
  };
  std::vector<Kept> kept_;
};

}  // namespace intaglio
