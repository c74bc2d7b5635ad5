#include "engrave/render/plane.h"

#include <algorithm>

namespace intaglio::render {
namespace {

/// The running mean of each row.
void BlurRows(const Plane& in, Plane& out, int radius) {
  const double share = 1.0 / (2 * radius + 1);
  const auto width = static_cast<std::size_t>(in.width);
  for (std::size_t y = 0; y < static_cast<std::size_t>(in.height); ++y) {
    const float* from = &in.values[y * width];
    float* to = &out.values[y * width];
    double sum = 0.0;
    for (int x = 0; x < std::min(radius, in.width); ++x) sum += from[x];
    for (int x = 0; x < in.width; ++x) {
      if (x + radius < in.width) sum += from[x + radius];
      if (x - radius > 0) sum -= from[x - radius - 1];
      to[x] = static_cast<float>(sum * share);
    }
  }
}

/// The running mean of each column. All columns advance together, row by row, as the
/// memory lies.
void BlurColumns(const Plane& in, Plane& out, int radius) {
  const double share = 1.0 / (2 * radius + 1);
  const auto width = static_cast<std::size_t>(in.width);
  std::vector<double> sums(width, 0.0);
  const auto row = [&](int y) { return &in.values[static_cast<std::size_t>(y) * width]; };
  const auto add = [&](const float* values) {
    for (std::size_t x = 0; x < width; ++x) sums[x] += values[x];
  };
  for (int y = 0; y < std::min(radius, in.height); ++y) add(row(y));
  for (int y = 0; y < in.height; ++y) {
    if (y + radius < in.height) add(row(y + radius));
    if (y - radius > 0) {
      const float* gone = row(y - radius - 1);
      for (std::size_t x = 0; x < width; ++x) sums[x] -= gone[x];
    }
    float* to = &out.values[static_cast<std::size_t>(y) * width];
    for (std::size_t x = 0; x < width; ++x) to[x] = static_cast<float>(sums[x] * share);
  }
}

}  // namespace

Plane Blurred(const Plane& plane, int radius_px) {
  Plane result = plane;
  if (radius_px < 1) return result;
  Plane other = plane;
  for (int pass = 0; pass < 3; ++pass) {
    BlurRows(result, other, radius_px);
    BlurColumns(other, result, radius_px);
  }
  return result;
}

}  // namespace intaglio::render
