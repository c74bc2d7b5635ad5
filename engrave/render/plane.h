#pragma once

// A picture of one number per pixel, for the steps between points and colours.

#include <cstddef>
#include <vector>

#include "engrave/render/canvas.h"

namespace intaglio::render {

struct Plane {
  int left = 0;  ///< The first column, and so `top`: at(left, top) is values[0].
  int top = 0;
  int width = 0;
  int height = 0;
  std::vector<float> values;  ///< Row by row.

  Plane(int plane_width, int plane_height, float fill)
      : Plane(Rect{0, 0, plane_width, plane_height}, fill) {}

  /// The pixels of `area` alone.
  Plane(const Rect& area, float fill)
      : left(area.x),
        top(area.y),
        width(area.width),
        height(area.height),
        values(
            static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height),
            fill) {}

  Rect area() const { return {left, top, width, height}; }
  int right() const { return left + width; }  ///< Behind the last column.
  int bottom() const { return top + height; }
  bool Has(int x, int y) const {
    return x >= left && y >= top && x < right() && y < bottom();
  }
  float& at(int x, int y) { return values[Index(x, y)]; }
  float at(int x, int y) const { return values[Index(x, y)]; }

 private:
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y - top) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x - left);
  }
};

/// A soft blur, near to Gaussian: three box filters of 2 radius + 1 pixels each way.
/// What lies outside the plane counts as 0.
Plane Blurred(Plane plane, int radius_px);

}  // namespace intaglio::render
