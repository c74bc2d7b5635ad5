#pragma once

// The file of a model as it is sent and read: with all that belongs to it.

#include <cstdint>
#include <filesystem>
#include <string>

#include "engrave/core/result.h"

namespace intaglio {

/// Whether files of this name may consist of several.
bool HasOtherFiles(const std::filesystem::path& file);

/// The whole file. The buffers of a .gltf that are files of their own are read from its
/// folder and written into it as data URIs: a shop sends one file a model. Errors as
/// io::ReadWholeFile() has them, also of the buffers, and kTooLarge for more than
/// `max_bytes` with them; kUnsupported: a buffer outside the folder.
Result<std::string> ReadModelFile(const std::filesystem::path& file,
                                  std::uint64_t max_bytes);

}  // namespace intaglio
