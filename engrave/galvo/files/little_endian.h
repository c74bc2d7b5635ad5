#pragma once

// Numbers in the order of bytes of all files here, least significant byte first.

#include <bit>
#include <cstddef>
#include <cstring>
#include <span>
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

/// All numbers from `at` on; the bytes have to reach behind the last.
template <typename Number>
void CopyLittleEndian(std::string_view bytes, std::size_t at, std::span<Number> numbers) {
  const std::string_view taken = bytes.substr(at, numbers.size_bytes());
  std::memcpy(numbers.data(), taken.data(), taken.size());
}

template <typename Number>
void AppendLittleEndian(std::span<const Number> numbers, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes());
}

template <typename Number>
void AppendLittleEndian(Number number, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

}  // namespace intaglio::galvo
