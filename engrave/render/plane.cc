#include "engrave/render/plane.h"

#include <algorithm>
#include <array>

namespace intaglio::render {
namespace {

/// The running means of `kRows` rows from row `first` on. Each sum waits for the one
/// before it, so several rows advance together.
template <std::size_t kRows>
void BlurSomeRows(const Plane& in, Plane& out, int radius, int first) {
  const double share = 1.0 / (2 * radius + 1);
  std::array<const float*, kRows> from;
  std::array<float*, kRows> to;
  std::array<double, kRows> sums{};
  for (std::size_t row = 0; row < kRows; ++row) {
    const std::size_t start =
        (static_cast<std::size_t>(first) + row) * static_cast<std::size_t>(in.width);
    from[row] = &in.values[start];
    to[row] = &out.values[start];
    for (int x = 0; x < std::min(radius, in.width); ++x) sums[row] += from[row][x];
  }
  for (int x = 0; x < in.width; ++x) {
    for (std::size_t row = 0; row < kRows; ++row) {
      if (x + radius < in.width) sums[row] += from[row][x + radius];
      if (x - radius > 0) sums[row] -= from[row][x - radius - 1];
      to[row][x] = static_cast<float>(sums[row] * share);
    }
  }
}

/// The running mean of each row.
void BlurRows(const Plane& in, Plane& out, int radius) {
  constexpr int kTogether = 4;
  int y = 0;
  for (; y + kTogether <= in.height; y += kTogether) {
    BlurSomeRows<kTogether>(in, out, radius, y);
  }
  for (; y < in.height; ++y) BlurSomeRows<1>(in, out, radius, y);
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

Plane Blurred(Plane plane, int radius_px) {
  if (radius_px < 1) return plane;
  Plane other(plane.area(), 0.0F);
  for (int pass = 0; pass < 3; ++pass) {
    BlurRows(plane, other, radius_px);
    BlurColumns(other, plane, radius_px);
  }
  return plane;
}

}  // namespace intaglio::render
