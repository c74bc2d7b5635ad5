#pragma once

// Numbers in the order of bytes of all files here, least significant byte first.

#include <bit>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>

namespace intaglio::galvo {

static_assert(std::endian::native == std::endian::little,
              "numbers are copied as this processor has them");

/// The number at `at`; the bytes have to reach behind it.
template <typename Number>
Number LittleEndian(std::string_view bytes, std::size_t at) {
  Number number;
  std::memcpy(&number, bytes.substr(at, sizeof number).data(), sizeof number);
  return number;
}

template <typename Number>
void AppendLittleEndian(Number number, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

}  // namespace intaglio::galvo
