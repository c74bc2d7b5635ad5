#include "engrave/image/luminance.h"

#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::image {

double LinearOfSrgb(double value) {
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

double SrgbOfLinear(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

Luminance::Luminance(const ImageOptions& options, bool wide, double gamma)
    : top_(wide ? 65535 : 255),
      background_(static_cast<std::uint64_t>(std::lround(options.background * 65535))) {
  Require(options.background >= 0 && options.background <= 1,
          "the background must be 0..1, is {}", options.background);
  constexpr double kScale = 65535.0 * 65536.0;
  for (std::uint64_t i = 0; i <= top_; ++i) {
    const double stored = static_cast<double>(i) / static_cast<double>(top_);
    const double value = options.samples == Samples::kAsStored ? stored
                         : gamma > 0                           ? std::pow(stored, gamma)
                                                               : LinearOfSrgb(stored);
    // The green takes what rounding leaves, so that white is 65535 exactly.
    const auto whole = static_cast<std::uint32_t>(std::llround(value * kScale));
    const auto red = static_cast<std::uint32_t>(std::llround(value * 0.2126 * kScale));
    const auto blue = static_cast<std::uint32_t>(std::llround(value * 0.0722 * kScale));
    red_.push_back(red);
    blue_.push_back(blue);
    green_.push_back(whole - red - blue);
  }
}

}  // namespace intaglio::image
