#pragma once

// Files that nobody but their owner may read.

#include <cstdint>
#include <filesystem>
#include <string>

#include "engrave/core/result.h"

namespace intaglio::access {

/// The whole file. kRefused: others can read or write it; the message has the remedy.
/// kNotFound, kIo, kTooLarge as io::ReadWholeFile.
Result<std::string> ReadSecretFile(const std::filesystem::path& file,
                                   std::uint64_t max_bytes);

}  // namespace intaglio::access
