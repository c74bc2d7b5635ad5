#include "services/job/models/kept_meshes.h"

#include <functional>
#include <string_view>
#include <utility>

#include "engrave/core/try.h"

namespace intaglio {

mesh::MeshReader KeptMeshes::Around(mesh::MeshReader read) {
  return [this, read = std::move(read)](
             std::span<const std::byte> bytes, std::string_view extension,
             const mesh::ImportOptions& options,
             std::string_view name) -> Result<mesh::ImportedMesh> {
    if (bytes.size() > kMaxFileBytes) return read(bytes, extension, options, name);
    const std::size_t hash = std::hash<std::string_view>()(
        {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    for (const Kept& kept : kept_) {
      if (kept.name == name && kept.objects == options.objects &&
          kept.byte_count == bytes.size() && kept.hash == hash)
        return kept.mesh;
    }
    auto mesh = INTAGLIO_TRY(read(bytes, extension, options, name));
    kept_.push_back({std::string(name), options.objects, bytes.size(), hash, mesh});
    return mesh;
  };
}

}  // namespace intaglio
