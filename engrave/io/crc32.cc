#include "engrave/io/crc32.h"

#include <zlib.h>

namespace intaglio::io {

std::uint32_t Crc32(std::span<const std::byte> bytes, std::uint32_t before) {
  // For a null pointer zlib returns the initial value, whatever the previous one.
  if (bytes.empty()) return before;
  return static_cast<std::uint32_t>(
      crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace intaglio::io
