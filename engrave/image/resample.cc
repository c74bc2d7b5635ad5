#include "engrave/image/resample.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/core/check.h"

// Both filters are products of one in x and one in y: a new row is the weighted sum of
// old rows, each made narrow once. The kernel of a pixel made smaller by s > 1 is
//   area     the box of width s (at s = 1 and less the hat of width 2: straight lines)
//   Lanczos  sinc(x / s) sinc(x / 3 s), |x| < 3 s, s >= 1
// with weights that sum to one.

namespace intaglio::image {
namespace {

/// What one new pixel takes: weights of the old ones from `first` on.
struct Taps {
  int first = 0;
  std::vector<float> weights;
};

double Sinc(double x) {
  return x == 0 ? 1 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
}

double Weight(Filter filter, double centre, double step, int i) {
  const double scale = std::max(step, 1.0);
  if (filter == Filter::kLanczos) {
    const double x = (i + 0.5 - centre) / scale;
    return std::abs(x) < 3 ? Sinc(x) * Sinc(x / 3) : 0;
  }
  if (step <= 1) return std::max(0.0, 1 - std::abs(i + 0.5 - centre));
  const double covered =
      std::min(i + 1.0, centre + step / 2) - std::max(i + 0.0, centre - step / 2);
  return std::max(0.0, covered);
}

std::vector<Taps> TapsOf(Filter filter, int old_count, int new_count, double low,
                         double high) {
  const double step = (high - low) * old_count / new_count;
  const double scale = std::max(step, 1.0);
  const double reach =
      filter == Filter::kLanczos ? 3 * scale : (step > 1 ? step / 2 : 1.0);
  std::vector<Taps> all(static_cast<std::size_t>(new_count));
  for (int n = 0; n < new_count; ++n) {
    const double centre = low * old_count + (n + 0.5) * step;
    const int from = static_cast<int>(std::floor(centre - reach));
    const int to = static_cast<int>(std::ceil(centre + reach));
    Taps& taps = all[static_cast<std::size_t>(n)];
    taps.first = std::clamp(from, 0, old_count - 1);
    const int last = std::clamp(to, taps.first, old_count - 1);
    std::vector<double> weights(static_cast<std::size_t>(last - taps.first + 1));
    double sum = 0;
    for (int i = from; i <= to; ++i) {
      const double weight = Weight(filter, centre, step, i);
      weights[static_cast<std::size_t>(std::clamp(i, taps.first, last) - taps.first)] +=
          weight;
      sum += weight;
    }
    for (const double weight : weights) {
      taps.weights.push_back(static_cast<float>(weight / sum));
    }
  }
  return all;
}

template <typename Value>
void Narrow(const Value* row, const std::vector<Taps>& across, float unit, float* out) {
  for (const Taps& taps : across) {
    const Value* value = row + taps.first;
    float sum = 0;
    for (const float weight : taps.weights) sum += weight * static_cast<float>(*value++);
    *out++ = sum * unit;
  }
}

template <typename Value>
FloatImage ResampleRows(const Value* values, int old_width, int old_height, float unit,
                        int width, int height, Filter filter, const Window& window) {
  Require(old_width > 0 && old_height > 0, "the picture is empty: {} x {}", old_width,
          old_height);
  Require(width > 0 && height > 0, "there must be new pixels, not {} x {}", width,
          height);
  Require(window.right > window.left && window.bottom > window.top,
          "the window is empty: {}..{}, {}..{}", window.left, window.right, window.top,
          window.bottom);
  const auto across = TapsOf(filter, old_width, width, window.left, window.right);
  const auto down = TapsOf(filter, old_height, height, window.top, window.bottom);
  std::size_t largest = 1;
  for (const Taps& taps : down) largest = std::max(largest, taps.weights.size());
  const auto row_size = static_cast<std::size_t>(width);
  std::vector<float> narrow(largest * row_size);  // old row y is at y % most
  FloatImage result{width, height, std::vector<float>(row_size * down.size())};
  int done = down.front().first;
  for (std::size_t y = 0; y < down.size(); ++y) {
    const Taps& taps = down[y];
    const int end = taps.first + static_cast<int>(taps.weights.size());
    for (done = std::max(done, taps.first); done < end; ++done) {
      Narrow(
          values + static_cast<std::size_t>(done) * static_cast<std::size_t>(old_width),
          across, unit,
          narrow.data() + static_cast<std::size_t>(done) % largest * row_size);
    }
    float* out = result.values.data() + y * row_size;
    for (int i = taps.first; i < end; ++i) {
      const float weight = taps.weights[static_cast<std::size_t>(i - taps.first)];
      const float* row = narrow.data() + static_cast<std::size_t>(i) % largest * row_size;
      for (std::size_t x = 0; x < row_size; ++x) out[x] += weight * row[x];
    }
    for (std::size_t x = 0; x < row_size; ++x) out[x] = std::clamp(out[x], 0.0F, 1.0F);
  }
  return result;
}

}  // namespace

FloatImage Resample(const GreyImage& image, int width, int height, Filter filter,
                    const Window& window) {
  return ResampleRows(image.samples.data(), image.width, image.height,
                      1.0F / GreyImage::kWhite, width, height, filter, window);
}

FloatImage Resample(const FloatImage& image, int width, int height, Filter filter,
                    const Window& window) {
  return ResampleRows(image.values.data(), image.width, image.height, 1.0F, width, height,
                      filter, window);
}

float Interpolate(const FloatImage& image, double x, double y) {
  const auto place = [](double share, int count, int& low, int& high) {
    const double at = std::clamp(share * count - 0.5, 0.0, count - 1.0);
    low = static_cast<int>(at);
    high = std::min(low + 1, count - 1);
    return static_cast<float>(at - low);
  };
  int x0 = 0, x1 = 0, y0 = 0, y1 = 0;
  const float u = place(x, image.width, x0, x1), v = place(y, image.height, y0, y1);
  const float above = image.at(x0, y0) * (1 - u) + image.at(x1, y0) * u;
  const float below = image.at(x0, y1) * (1 - u) + image.at(x1, y1) * u;
  return above * (1 - v) + below * v;
}

}  // namespace intaglio::image
