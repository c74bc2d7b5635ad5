#pragma once

// The files beside a glTF that its buffers lie in (glTF 2.0, 3.6.1.1: buffers[].uri). A
// uri is a relative reference, and what it names belongs to the model only below the
// model's folder.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::mesh {

struct GltfBufferFile {
  std::string path;  ///< relative to the folder of the glTF, without "..", not empty
  std::size_t begin = 0, end = 0;  ///< of the uri in the text, with its quotes
};

/// In the order of the text; without those that are written in it (data:). Text that is
/// no JSON has none, or what resembles one: its reader refuses it. kUnsupported: an
/// absolute path, a path with "..", an address, or an escape that is no path.
Result<std::vector<GltfBufferFile>> BufferFilesOf(std::string_view json);

}  // namespace intaglio::mesh
