#include "engrave/calibrate/mark_centres.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "engrave/calibrate/median.h"

// The background is the median of tiles far larger than a mark, interpolated between
// their middles; what differs from it, relative to it, is the signal. Noise is estimated
// by the median of its size. Pixels beyond a threshold form spots; the centre of a spot
// is the centroid of the signal in a round window around it, which is moved until it
// rests, so that it has as much of the mark on each side. Signals below the noise are not
// counted, so that the window's rim adds none.

namespace intaglio::calibrate {
namespace {

constexpr double kTileDiameters = 8;
constexpr double kFewMarks = 8;
constexpr double kNoiseFactor = 6;     // threshold over noise
constexpr double kPeakShare = 0.35;    // and over the strong marks
constexpr double kCountedShare = 0.1;  // of its peak: what a centroid counts
constexpr int kMoves = 20;

struct Signal {
  int width = 0, height = 0;
  std::vector<float> values;  // positive: a mark
  float at(int x, int y) const {
    return values[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                  static_cast<std::size_t>(x)];
  }
};

/// Medians of tiles, and bilinear between their middles and beyond the outermost.
class Background {
 public:
  Background(const image::GreyImage& picture, int tile_px)
      : columns_(std::max(1, picture.width / tile_px)),
        rows_(std::max(1, picture.height / tile_px)),
        width_px_(static_cast<double>(picture.width) / columns_),
        height_px_(static_cast<double>(picture.height) / rows_) {
    std::vector<float> values;
    for (int r = 0; r < rows_; ++r) {
      for (int c = 0; c < columns_; ++c) {
        values.clear();
        for (int y = static_cast<int>(r * height_px_);
             y < static_cast<int>((r + 1) * height_px_); ++y) {
          for (int x = static_cast<int>(c * width_px_);
               x < static_cast<int>((c + 1) * width_px_); ++x) {
            values.push_back(picture.at(x, y));
          }
        }
        medians_.push_back(MedianOf(values));
      }
    }
  }
  float At(int x, int y) const {
    const double u = (x + 0.5) / width_px_ - 0.5, v = (y + 0.5) / height_px_ - 0.5;
    const int c = std::clamp(static_cast<int>(u), 0, std::max(0, columns_ - 2));
    const int r = std::clamp(static_cast<int>(v), 0, std::max(0, rows_ - 2));
    const double fu = u - c, fv = v - r;
    return static_cast<float>((1 - fv) * ((1 - fu) * Of(c, r) + fu * Of(c + 1, r)) +
                              fv * ((1 - fu) * Of(c, r + 1) + fu * Of(c + 1, r + 1)));
  }

 private:
  double Of(int c, int r) const {
    return medians_[static_cast<std::size_t>(std::min(r, rows_ - 1) * columns_ +
                                             std::min(c, columns_ - 1))];
  }
  int columns_, rows_;
  double width_px_, height_px_;  // of a tile
  std::vector<float> medians_;
};

Signal SignalOf(const image::GreyImage& picture, double diameter_px) {
  const int tile_px = std::max(16, static_cast<int>(kTileDiameters * diameter_px));
  const Background background(picture, tile_px);
  Signal signal{picture.width, picture.height, {}};
  signal.values.reserve(picture.samples.size());
  for (int y = 0; y < picture.height; ++y) {
    for (int x = 0; x < picture.width; ++x) {
      const float ground = std::max(1.0F, background.At(x, y));
      signal.values.push_back((static_cast<float>(picture.at(x, y)) - ground) / ground);
    }
  }
  return signal;
}

double NoiseOf(const Signal& signal) {
  std::vector<float> sizes;
  sizes.reserve(signal.values.size());
  for (const float value : signal.values) sizes.push_back(std::abs(value));
  return std::max(1e-5, kNormalMad * MedianOf(sizes));
}

/// The signal that the pixels of a few marks exceed; noise alone exceeds less.
double PeakOf(const Signal& signal, double diameter_px) {
  const auto few = static_cast<std::size_t>(kFewMarks * diameter_px * diameter_px) + 1;
  std::vector<float> values = signal.values;
  const auto at =
      values.end() - static_cast<std::ptrdiff_t>(std::min(few, values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Connected pixels beyond the threshold: their mean place and count.
struct Spot {
  Vec2 middle_px = Vec2::Zero();
  int pixels = 0;
};

std::vector<Spot> SpotsOf(const Signal& signal, double threshold) {
  std::vector<Spot> spots;
  std::vector<bool> seen(signal.values.size());
  std::vector<std::pair<int, int>> open;
  const auto take = [&](int x, int y) {
    if (x < 0 || y < 0 || x >= signal.width || y >= signal.height) return;
    const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(signal.width) +
                   static_cast<std::size_t>(x);
    if (seen[i] || signal.values[i] < threshold) return;
    seen[i] = true;
    open.emplace_back(x, y);
  };
  for (int y = 0; y < signal.height; ++y) {
    for (int x = 0; x < signal.width; ++x) {
      take(x, y);
      Spot spot;
      while (!open.empty()) {
        const auto [px, py] = open.back();
        open.pop_back();
        spot.middle_px += Vec2(px, py);
        ++spot.pixels;
        take(px + 1, py), take(px - 1, py), take(px, py + 1), take(px, py - 1);
      }
      if (spot.pixels == 0) continue;
      spot.middle_px /= spot.pixels;
      spots.push_back(spot);
    }
  }
  return spots;
}

Vec2 CentroidAt(const Signal& signal, Vec2 at_px, double radius_px, double counted) {
  for (int move = 0; move < kMoves; ++move) {
    Vec2 sum = Vec2::Zero();
    double weight = 0;
    const int reach = static_cast<int>(radius_px) + 2;
    const int cx = static_cast<int>(std::lround(at_px.x())),
              cy = static_cast<int>(std::lround(at_px.y()));
    for (int y = std::max(0, cy - reach); y <= std::min(signal.height - 1, cy + reach);
         ++y) {
      for (int x = std::max(0, cx - reach); x <= std::min(signal.width - 1, cx + reach);
           ++x) {
        // A pixel at the rim counts by its share, so that the window moves smoothly.
        const double inside =
            std::clamp(radius_px + 0.5 - (Vec2(x, y) - at_px).norm(), 0.0, 1.0);
        const double value = signal.at(x, y) - counted;
        if (inside == 0 || value <= 0) continue;
        sum += inside * value * Vec2(x, y);
        weight += inside * value;
      }
    }
    if (weight <= 0) return at_px;
    const Vec2 next_px = sum / weight;
    const bool rests = (next_px - at_px).norm() < 1e-4;
    at_px = next_px;
    if (rests) break;
  }
  return at_px;
}

}  // namespace

Result<std::vector<Vec2>> FindMarkCentres(const image::GreyImage& picture,
                                          const CentreOptions& options) {
  const double d = options.diameter_px;
  if (!(d >= 3 && d <= 200)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("a mark of {} pixels is outside 3..200; take a picture in "
                            "which a mark has 5 to 20 pixels",
                            d));
  }
  if (picture.width < 4 * d || picture.height < 4 * d) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("a picture of {} x {} pixels has no room for marks of {}",
                            picture.width, picture.height, d));
  }
  Signal signal = SignalOf(picture, d);
  const double bright = PeakOf(signal, d);
  for (float& value : signal.values) value = -value;
  const double dark = PeakOf(signal, d);
  const bool as_bright = options.tone == MarkTone::kBright ||
                         (options.tone == MarkTone::kEither && bright > dark);
  if (as_bright) {
    for (float& value : signal.values) value = -value;
  }
  const double peak = as_bright ? bright : dark, noise = NoiseOf(signal);
  const double threshold = std::max(kNoiseFactor * noise, kPeakShare * peak);
  const double area_px = std::numbers::pi / 4 * d * d;
  std::vector<Vec2> centres_px;
  for (const Spot& spot : SpotsOf(signal, threshold)) {
    if (spot.pixels < 0.25 * area_px * kPeakShare || spot.pixels > 4 * area_px) continue;
    const double counted = std::max(2 * noise, kCountedShare * peak);
    centres_px.push_back(CentroidAt(signal, spot.middle_px, 0.9 * d, counted));
  }
  if (centres_px.empty()) {
    return Fail(ErrorCode::kMissing,
                "the picture has no mark that stands out from the noise; light the block "
                "from the side before a dark ground, and check the size of a mark");
  }
  return centres_px;
}

}  // namespace intaglio::calibrate
