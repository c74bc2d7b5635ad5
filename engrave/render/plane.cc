#include "engrave/render/plane.h"

#include <algorithm>

namespace intaglio::render {
namespace {

/// A running mean of `count` values `stride` apart, from `in` to `out`.
void BoxFilter(const float* in, float* out, int count, std::size_t stride, int radius) {
  const double share = 1.0 / (2 * radius + 1);
  double sum = 0.0;
  for (int i = 0; i < std::min(radius, count); ++i) {
    sum += in[static_cast<std::size_t>(i) * stride];
  }
  for (int i = 0; i < count; ++i) {
    if (i + radius < count) sum += in[static_cast<std::size_t>(i + radius) * stride];
    if (i - radius > 0) sum -= in[static_cast<std::size_t>(i - radius - 1) * stride];
    out[static_cast<std::size_t>(i) * stride] = static_cast<float>(sum * share);
  }
}

}  // namespace

Plane Blurred(const Plane& plane, int radius_px) {
  Plane result = plane;
  if (radius_px < 1) return result;
  Plane other = plane;
  const auto width = static_cast<std::size_t>(plane.width);
  for (int pass = 0; pass < 3; ++pass) {
    for (std::size_t y = 0; y < static_cast<std::size_t>(plane.height); ++y) {
      BoxFilter(&result.values[y * width], &other.values[y * width], plane.width, 1,
                radius_px);
    }
    for (std::size_t x = 0; x < width; ++x) {
      BoxFilter(&other.values[x], &result.values[x], plane.height, width, radius_px);
    }
  }
  return result;
}

}  // namespace intaglio::render
