#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace intaglio::io {

/// CRC-32 (ISO 3309; polynomial 0x04C11DB7, reflected), as zlib, PNG and MCAP compute it,
/// of `bytes` that follow those of which `before` is the CRC-32. Of no bytes: 0.
std::uint32_t Crc32(std::span<const std::byte> bytes, std::uint32_t before = 0);

}  // namespace intaglio::io
