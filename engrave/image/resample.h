#pragma once

// A picture, or a part of it, in another number of pixels.

#include <cstddef>
#include <vector>

#include "engrave/image/grey_image.h"

namespace intaglio::image {

/// Brightness 0..1 (0 black), row 0 on top.
struct FloatImage {
  int width = 0;
  int height = 0;
  std::vector<float> values;  ///< width * height

  float at(int x, int y) const {
    return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
  float& at(int x, int y) {
    return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

/// A part of a picture as shares of its width and height: 0, 0 the upper left corner, 1,
/// 1 the lower right. It may extend beyond the picture: there the border pixels are
/// repeated.
struct Window {
  double left = 0, top = 0, right = 1, bottom = 1;
};

enum class Filter {
  /// The mean over the area of a new pixel, exactly: keeps every sum, makes no new
  /// extremes. Where pixels are made larger, straight lines between their centres.
  kArea,
  /// Lanczos of three lobes, widened to the new pixel: sharper edges at the price of a
  /// slight overshoot beside them; clamped to 0..1.
  kLanczos,
};

/// width, height > 0; the picture not empty. Time: one pass over the picture.
FloatImage Resample(const GreyImage& image, int width, int height,
                    Filter filter = Filter::kArea, const Window& window = {});
FloatImage Resample(const FloatImage& image, int width, int height,
                    Filter filter = Filter::kArea, const Window& window = {});

/// Between the centres of pixels by straight lines; x, y as shares like those of Window.
float Interpolate(const FloatImage& image, double x, double y);

}  // namespace intaglio::image
