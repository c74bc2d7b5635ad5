#pragma once

// A picture of one number per pixel, for the steps between points and colours.

#include <cstddef>
#include <vector>

namespace intaglio::render {

struct Plane {
  int width = 0;
  int height = 0;
  std::vector<float> values;  ///< Row by row.

  Plane(int plane_width, int plane_height, float fill)
      : width(plane_width),
        height(plane_height),
        values(static_cast<std::size_t>(plane_width) *
                   static_cast<std::size_t>(plane_height),
               fill) {}

  bool Has(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  float& at(int x, int y) { return values[Index(x, y)]; }
  float at(int x, int y) const { return values[Index(x, y)]; }

 private:
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

/// A soft blur, near to Gaussian: three box filters of 2 radius + 1 pixels each way.
/// What lies outside counts as 0.
Plane Blurred(const Plane& plane, int radius_px);

}  // namespace intaglio::render
