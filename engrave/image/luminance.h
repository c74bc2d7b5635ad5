#pragma once

// From the colours of a file to the samples of a GreyImage.

#include <array>
#include <cstdint>
#include <vector>

#include "engrave/image/image_file.h"

namespace intaglio::image {

/// Linear light of an sRGB value and back, both 0..1 (IEC 61966-2-1).
double LinearOfSrgb(double value);
double SrgbOfLinear(double light);

/// Channels of 8 bits, or of 16 when `wide`. A table a channel.
class Luminance {
 public:
  /// `gamma`: the file's value is light^(1 / gamma); 0: the curve of sRGB.
  Luminance(const ImageOptions& options, bool wide, double gamma = 0);

  std::uint16_t Of(unsigned r, unsigned g, unsigned b) const {
    return static_cast<std::uint16_t>((red_[r] + green_[g] + blue_[b] + kHalf) >> 16);
  }
  std::uint16_t Of(unsigned r, unsigned g, unsigned b, unsigned alpha) const {
    return Over(Of(r, g, b), alpha);
  }
  /// A sample in front of the background.
  std::uint16_t Over(std::uint64_t sample, unsigned alpha) const {
    return static_cast<std::uint16_t>(
        (sample * alpha + background_ * (top_ - alpha) + top_ / 2) / top_);
  }

 private:
  static constexpr std::uint32_t kHalf = 1U << 15;

  std::uint64_t top_;                              // largest value of a channel
  std::uint64_t background_;                       // 0..65535
  std::vector<std::uint32_t> red_, green_, blue_;  // 65535 * 65536 is white in all
};

}  // namespace intaglio::image
