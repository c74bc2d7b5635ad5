#include "engrave/drawing/hpgl_encoded.h"

#include <cmath>

namespace intaglio::drawing {
namespace {

constexpr int kFirstDigit = 63;
constexpr int kMaxBits = 50;

}  // namespace

std::optional<double> HpglEncoded::Number() {
  const int bits = base_32_ ? 5 : 6, base = 1 << bits;
  // Seven bits: the last digit follows the others; eight: it has the highest bit.
  const int last_digit = base_32_ ? kFirstDigit + base : kFirstDigit + 128;
  std::uint64_t number = 0;
  for (int shift = 0; at_ < text_.size() && shift <= kMaxBits;) {
    const int c = static_cast<unsigned char>(text_[at_]);
    const bool ends = c >= last_digit && c < last_digit + base;
    const bool continues = c >= kFirstDigit && c < kFirstDigit + base;
    if (c == ';') return std::nullopt;
    ++at_;
    if (!ends && !continues) continue;  // as the standard defines: ignored
    const int digit = c - (ends ? last_digit : kFirstDigit);
    number |= static_cast<std::uint64_t>(digit) << shift;
    shift += bits;
    if (!ends) continue;
    const auto size = static_cast<double>(number >> 1);
    return (number & 1) != 0 ? -size : size;
  }
  return std::nullopt;
}

HpglStep HpglEncoded::Next() {
  using Kind = HpglStep::Kind;
  HpglStep step;
  while (at_ < text_.size()) {
    const char c = text_[at_];
    if (c == ';') return step;
    if (c == '<') step.down = false;
    if (c == '=') step.absolute = true;
    if (c == '7') base_32_ = true;
    if (c == ':' || c == '>') {
      ++at_;
      const std::optional<double> number = Number();
      if (!number || std::abs(*number) > kMaxBits + 0.0) {
        step.kind = Kind::kWrong;
        return step;
      }
      if (c == '>') {
        fraction_bits_ = static_cast<int>(*number);
        continue;
      }
      step.kind = Kind::kPen;
      step.pen = *number;
      return step;
    }
    if (static_cast<unsigned char>(c) >= kFirstDigit) {
      const std::optional<double> x = Number();
      const std::optional<double> y = x ? Number() : std::nullopt;
      step.kind = y ? Kind::kMove : Kind::kWrong;
      if (y)
        step.at = Vec2(std::ldexp(*x, -fraction_bits_), std::ldexp(*y, -fraction_bits_));
      return step;
    }
    ++at_;
  }
  return step;
}

}  // namespace intaglio::drawing
