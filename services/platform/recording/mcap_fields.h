#pragma once

// The fields of MCAP records, little endian: numbers, texts with a 4-byte length, maps.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace intaglio::recording {

static_assert(std::endian::native == std::endian::little,
              "the codec copies numbers as they lie in memory");

using Bytes = std::vector<std::byte>;
using ByteView = std::span<const std::byte>;
using TextMap = std::map<std::string, std::string>;

template <typename T>
requires std::is_arithmetic_v<T>
void Put(Bytes& bytes, T value) {
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof value);
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

inline void PutRaw(Bytes& bytes, ByteView raw) {
  const std::size_t at = bytes.size();
  bytes.resize(at + raw.size());
  if (!raw.empty()) std::memcpy(bytes.data() + at, raw.data(), raw.size());
}

inline void PutText(Bytes& bytes, std::string_view text) {
  Put(bytes, static_cast<std::uint32_t>(text.size()));
  PutRaw(bytes, std::as_bytes(std::span(text)));
}

inline void PutMap(Bytes& bytes, const TextMap& map) {
  std::uint32_t size = 0;
  for (const auto& [key, value] : map) {
    size += static_cast<std::uint32_t>(8 + key.size() + value.size());
  }
  Put(bytes, size);
  for (const auto& [key, value] : map) {
    PutText(bytes, key);
    PutText(bytes, value);
  }
}

/// Reading past the end gives zeros and nothing, and makes good() false for ever.
class FieldReader {
 public:
  explicit FieldReader(ByteView bytes) : bytes_(bytes) {}

  template <typename T>
  requires std::is_arithmetic_v<T> T Get() {
    T value{};
    const ByteView raw = GetRaw(sizeof value);
    if (!raw.empty()) std::memcpy(&value, raw.data(), sizeof value);
    return value;
  }
  ByteView GetRaw(std::uint64_t size) {
    if (bytes_.size() - at_ < size) {
      good_ = false;
      at_ = bytes_.size();
      return {};
    }
    const ByteView raw = bytes_.subspan(at_, static_cast<std::size_t>(size));
    at_ += raw.size();
    return raw;
  }
  std::string GetText() {
    const ByteView raw = GetRaw(Get<std::uint32_t>());
    return std::string(reinterpret_cast<const char*>(raw.data()), raw.size());
  }
  TextMap GetMap() {
    FieldReader entries(GetRaw(Get<std::uint32_t>()));
    TextMap map;
    while (entries.good() && entries.left() > 0) {
      std::string key = entries.GetText();
      map[std::move(key)] = entries.GetText();
    }
    good_ = good_ && entries.good();
    return map;
  }
  ByteView GetRest() { return GetRaw(left()); }
  std::size_t at() const { return at_; }
  std::size_t left() const { return bytes_.size() - at_; }
  bool good() const { return good_; }

 private:
  ByteView bytes_;
  std::size_t at_ = 0;
  bool good_ = true;
};

}  // namespace intaglio::recording
