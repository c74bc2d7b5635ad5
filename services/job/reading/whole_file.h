#pragma once

// What the process that reads a file and the one that asks it give each other: whole
// files, by their descriptors.

#include <cstddef>
#include <span>
#include <vector>

namespace intaglio::reading {

/// False when not all could be written.
bool WriteAll(int descriptor, std::span<const std::byte> bytes);

/// From its beginning to its end; empty when it cannot be read.
std::vector<std::byte> ReadAll(int descriptor);

}  // namespace intaglio::reading
