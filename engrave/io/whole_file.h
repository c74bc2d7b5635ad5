#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "engrave/core/result.h"

namespace intaglio::io {

/// The bytes of a regular file, as many as it has when it is opened. Errors name the file
/// and the remedy: kNotFound, kIo (a folder, a FIFO, a device, no permission, a failing
/// disk), kTooLarge (more than `max_bytes`, none of which are read).
Result<std::string> ReadWholeFile(const std::filesystem::path& file,
                                  std::uint64_t max_bytes);

/// The same in pieces of `piece_bytes`, the last one shorter, without all of them at
/// once; an empty file is one empty piece. `take(piece, size)`: `size` is that of the
/// file. Ends with the first error of `take`, which is named after the file.
Status ReadInPieces(const std::filesystem::path& file, std::uint64_t max_bytes,
                    std::size_t piece_bytes,
                    const std::function<Status(std::span<const std::byte> piece,
                                               std::uint64_t size)>& take);

/// The same of its first bytes, `count` or as many as it has, of a file of any size.
Result<std::string> ReadBeginning(const std::filesystem::path& file, std::uint64_t count);

/// Puts the file's name before an error of a parser.
Error AboutFile(Error error, const std::filesystem::path& file);

}  // namespace intaglio::io
