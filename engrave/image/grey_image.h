#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace intaglio::image {

/// A picture of one brightness per pixel: 0 black, 65535 white; row 0 on top, rows one
/// after another from the left. Samples are linear light (a photo) or the values as
/// stored (a depth map), as chosen in image_file.h. 16 bits: a step of 8-bit sRGB is at
/// least 20 steps of theirs, at half the memory of float.
struct GreyImage {
  static constexpr int kWhite = 65535;

  int width = 0;
  int height = 0;
  std::vector<std::uint16_t> samples;  ///< width * height

  std::uint16_t at(int x, int y) const {
    return samples[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                   static_cast<std::size_t>(x)];
  }
};

}  // namespace intaglio::image
