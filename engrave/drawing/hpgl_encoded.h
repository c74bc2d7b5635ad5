#pragma once

// The numbers of the instruction PE of HP-GL/2 (polyline encoded; HP-GL/2 and HP RTL
// reference guide, chapter 6): base 64 in bytes 63..126 and 191..254, or base 32
// in 63..94 and 95..126; the lowest digit first, the last digit from the upper range; bit
// 0 of the number is its sign.

#include <cstdint>
#include <optional>
#include <string_view>

#include "engrave/core/geometry.h"

namespace intaglio::drawing {

/// One step of the encoded polyline.
struct HpglStep {
  enum class Kind {
    kMove,  ///< of the pen by or to `at`
    kPen,   ///< pen `pen` is taken
    kEnd,   ///< the terminator, or the end of the file
    kWrong  ///< a number is cut, or too large
  };
  Kind kind = Kind::kEnd;
  Vec2 at = Vec2::Zero();  ///< user units
  bool absolute = false;
  bool down = true;
  double pen = 0;
};

/// The steps behind the letters PE, one after another.
class HpglEncoded {
 public:
  HpglEncoded(std::string_view text, std::size_t at) : text_(text), at_(at) {}

  HpglStep Next();
  /// Behind what was read.
  std::size_t position() const { return at_; }

 private:
  /// Nothing when it is cut or has more than 50 bits.
  std::optional<double> Number();

  std::string_view text_;
  std::size_t at_;
  bool base_32_ = false;
  int fraction_bits_ = 0;
};

}  // namespace intaglio::drawing
