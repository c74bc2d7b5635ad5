#pragma once

// Secrets: where they are kept, and how they are made.

#include <filesystem>
#include <string>

#include "engrave/core/result.h"

namespace intaglio::access {

/// 256 bits at random, as 64 hex digits.
std::string NewKey();

/// Replaces the file by one of mode 0600, whole or not at all. kIo.
Status WriteSecretFile(const std::filesystem::path& file, const std::string& text);

}  // namespace intaglio::access
