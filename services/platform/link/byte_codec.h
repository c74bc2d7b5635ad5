#pragma once

// Little-endian numbers in and out of a payload, with bounds that hold.

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace intaglio::link {

static_assert(std::endian::native == std::endian::little,
              "the codec copies numbers as they lie in memory");

/// Whether the last of `count` numbers would go round past zero.
inline bool GoesRound(std::uint64_t first, std::size_t count) {
  return first > std::numeric_limits<std::uint64_t>::max() - count;
}

class ByteWriter {
 public:
  template <typename T>
  requires std::is_arithmetic_v<T>
  void Put(T value) {
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof value);
    std::memcpy(bytes_.data() + at, &value, sizeof value);
  }
  void PutText(const std::string& text, std::size_t max_size) {
    const std::size_t size = std::min(text.size(), max_size);
    Put(static_cast<std::uint8_t>(size));
    for (std::size_t i = 0; i < size; ++i) bytes_.push_back(std::byte(text[i]));
  }
  std::vector<std::byte> Take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

/// Reading past the end gives zeros and makes good() false for ever.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  template <typename T>
  requires std::is_arithmetic_v<T> T Get() {
    T value{};
    if (bytes_.size() - at_ < sizeof value) {
      good_ = false;
      return value;
    }
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  /// One byte that has to be 0 or 1.
  bool GetFlag() {
    const auto value = Get<std::uint8_t>();
    good_ = good_ && value <= 1;
    return value == 1;
  }
  /// Printable ASCII alone: what people compare with a type plate.
  std::string GetPrintableText(std::size_t max_size) {
    std::string text = GetText(max_size);
    good_ = good_ && std::all_of(text.begin(), text.end(),
                                 [](char c) { return c >= ' ' && c <= '~'; });
    return text;
  }
  std::string GetText(std::size_t max_size) {
    const auto size = Get<std::uint8_t>();
    if (size > max_size || bytes_.size() - at_ < size) {
      good_ = false;
      return {};
    }
    std::string text(reinterpret_cast<const char*>(bytes_.data() + at_), size);
    at_ += size;
    return text;
  }
  bool good() const { return good_; }
  /// Everything was read, nothing is left.
  bool finished() const { return good_ && at_ == bytes_.size(); }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
  bool good_ = true;
};

}  // namespace intaglio::link
