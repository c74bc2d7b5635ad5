#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "engrave/core/result.h"

namespace intaglio::formats {

/// The bytes of a regular file, as many as it has when it is opened. Errors name the file
/// and the remedy: kNotFound, kIo (a folder, a FIFO, a device, no permission, a failing
/// disk), kTooLarge (more than `max_bytes`, none of which are read).
Result<std::string> ReadWholeFile(const std::filesystem::path& file,
                                  std::uint64_t max_bytes);

}  // namespace intaglio::formats
