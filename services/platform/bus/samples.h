#pragma once

// Filling and reading the plain C structs of the topics. A sample that is written only
// borrows: the strings and vectors must live until Write returns.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace intaglio::bus {

/// Lets a sample's string member point to a std::string's characters.
inline char* Borrow(const std::string& text) { return const_cast<char*>(text.c_str()); }

/// Lets a sample's sequence member use a vector's storage.
template <typename Sequence, typename Value>
void Borrow(Sequence& sequence, const std::vector<Value>& values) {
  using Element = std::remove_pointer_t<decltype(sequence._buffer)>;
  static_assert(sizeof(Element) == sizeof(Value));
  sequence._buffer = reinterpret_cast<Element*>(const_cast<Value*>(values.data()));
  sequence._length = sequence._maximum = static_cast<std::uint32_t>(values.size());
  sequence._release = false;
}

/// A view of a received sequence.
template <typename Sequence>
requires requires(const Sequence& s) { s._buffer; }
auto View(const Sequence& sequence) {
  return std::span(sequence._buffer, sequence._length);
}

/// A view of a received string; empty for a null pointer.
inline std::string_view View(const char* text) {
  return text == nullptr ? std::string_view() : std::string_view(text);
}

/// An age for a sample, ms, rounded up; of a time to come 0.
inline std::uint32_t AgeMs(std::chrono::nanoseconds age) {
  constexpr std::int64_t kMax = std::numeric_limits<std::uint32_t>::max();
  const auto ms = std::chrono::ceil<std::chrono::milliseconds>(age).count();
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(ms, 0, kMax));
}

}  // namespace intaglio::bus
