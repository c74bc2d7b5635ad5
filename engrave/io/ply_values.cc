#include "engrave/io/ply_values.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

#include "engrave/io/number_text.h"
#include "engrave/io/text_behind.h"

namespace intaglio::io {
namespace {

static_assert(std::endian::native == std::endian::little,
              "big-endian values are reversed for this machine");

/// take(T()) with the T of a PLY type.
template <typename Take>
std::optional<double> TakeAs(PlyType type, const Take& take) {
  switch (type) {
    case PlyType::kInt8:
      return take(std::int8_t());
    case PlyType::kUint8:
      return take(std::uint8_t());
    case PlyType::kInt16:
      return take(std::int16_t());
    case PlyType::kUint16:
      return take(std::uint16_t());
    case PlyType::kInt32:
      return take(std::int32_t());
    case PlyType::kUint32:
      return take(std::uint32_t());
    case PlyType::kFloat:
      return take(float());
    case PlyType::kDouble:
      return take(double());
  }
  return std::nullopt;
}

class BinaryValues final : public PlyValues {
 public:
  BinaryValues(std::string_view rest, bool big_endian)
      : rest_(rest), big_endian_(big_endian) {}

  std::optional<double> Next(PlyType type) override {
    return TakeAs(type, [this](auto kind) { return Take<decltype(kind)>(); });
  }
  bool has_more() const override { return !TextBehind(rest_, 0).empty(); }

 private:
  template <typename T>
  std::optional<double> Take() {
    std::array<char, sizeof(T)> bytes;
    if (rest_.size() < bytes.size()) return std::nullopt;
    std::memcpy(bytes.data(), rest_.data(), bytes.size());
    rest_.remove_prefix(bytes.size());
    if (big_endian_) std::reverse(bytes.begin(), bytes.end());
    return static_cast<double>(std::bit_cast<T>(bytes));
  }

  std::string_view rest_;
  bool big_endian_;
};

class AsciiValues final : public PlyValues {
 public:
  explicit AsciiValues(std::string_view rest) : rest_(rest) {}

  std::optional<double> Next(PlyType type) override {
    return TakeAs(type, [this]<typename T>(T) {
      if constexpr (std::is_integral_v<T>) {
        return TakeInteger<T>();
      } else {
        return Take<T>();
      }
    });
  }
  bool has_more() const override { return !TextBehind(rest_, 0).empty(); }

 private:
  template <typename T>
  std::optional<double> Take() {
    static constexpr std::string_view kBlanks = " \t\r\n";
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kBlanks), rest_.size()));
    const std::string_view word = rest_.substr(0, rest_.find_first_of(kBlanks));
    rest_.remove_prefix(word.size());
    return ParseNumber<T>(word);
  }

  // Some writers write integers with a decimal point ("255.0"); whole values in range are
  // accepted.
  template <typename T>
  std::optional<double> TakeInteger() {
    const std::optional<double> value = Take<double>();
    if (!value || *value != std::trunc(*value) ||
        *value < std::numeric_limits<T>::min() ||
        *value > std::numeric_limits<T>::max()) {
      return std::nullopt;
    }
    return value;
  }

  std::string_view rest_;
};

}  // namespace

std::unique_ptr<PlyValues> PlyValuesOf(PlyEncoding encoding, std::string_view rest) {
  if (encoding == PlyEncoding::kAscii) return std::make_unique<AsciiValues>(rest);
  return std::make_unique<BinaryValues>(rest, encoding == PlyEncoding::kBigEndian);
}

}  // namespace intaglio::io
