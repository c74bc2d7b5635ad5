#include "engrave/discretize/picture/halftone.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/discretize/picture/halftone_grid.h"
#include "engrave/discretize/picture/halftone_mask.h"
#include "engrave/discretize/picture/halftone_screen.h"
#include "engrave/discretize/picture/halftone_settle.h"
#include "engrave/discretize/spacing/candidate_limit.h"
#include "engrave/discretize/spacing/fixed_points.h"
#include "engrave/image/luminance.h"

// The brightness t of a place becomes the load g t, in units of what one layer can have;
// g is the number of layers, or less when a number of points is aimed at. Layer i of n
// gets clamp(g t - i, 0, 1) (overflow) or min(g t / n, 1) (even).

namespace intaglio::discretize {
namespace {

constexpr int kSamplesPerStep = 4;  // of the picture, before the means over cells
// How far points of several layers settle, as a share of the minimum distance seen from
// above: they stay a third of it apart.
constexpr double kReachRatio = 1.0 / 3;

bool IsTriangular(const HalftoneOptions& options) {
  return options.method == HalftoneMethod::kBlueNoise;
}

double ShareOf(double load, int layer, const HalftoneOptions& options) {
  return options.sharing == LayerSharing::kOverflow
             ? std::clamp(load - layer, 0.0, 1.0)
             : std::min(load / options.layer_count, 1.0);
}

/// The picture in a few samples a step of the grid, after the tone curve and threshold.
image::FloatImage Prepared(const image::GreyImage& picture, const HalftoneGrid& grid,
                           const HalftoneOptions& options) {
  image::FloatImage image =
      image::Resample(picture, std::min(picture.width, kSamplesPerStep * grid.columns),
                      std::min(picture.height, kSamplesPerStep * grid.rows));
  ApplyTone(options.tone, image);
  return image;
}

/// The g for which target_point_count points are expected; the g of the maximum number
/// when that is smaller.
double GainFor(const HalftoneGrid& grid, const HalftoneOptions& options) {
  const double largest = options.layer_count;
  if (options.target_point_count == 0) return largest;
  std::vector<float> bright;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const float t = grid.BrightnessAt(column, row);
      if (t > 0 && grid.Contains(grid.At(column, row))) bright.push_back(t);
    }
  }
  std::sort(bright.begin(), bright.end());
  // With a gain of g the places with g t >= most are full: from the brightest down, until
  // the rest has to be scaled by less than would fill the next.
  const auto target = static_cast<double>(options.target_point_count);
  double below = std::accumulate(bright.begin(), bright.end(), 0.0), full = 0;
  for (auto t = bright.rbegin(); t != bright.rend(); ++t) {
    const double gain = (target - full) / below;
    if (gain * *t <= largest) return gain;
    full += largest;
    below -= *t;
  }
  return bright.empty() ? largest : largest / bright.front();
}

/// The grid of kThreshold, widened until it gives no more points than the target.
HalftoneGrid ThresholdGrid(const image::GreyImage& picture, const Panel& panel,
                           const HalftoneOptions& options) {
  double distance_mm = options.vertex_distance_mm;
  HalftoneGrid grid(panel.width_mm, panel.height_mm, distance_mm, false);
  if (options.target_point_count == 0) return grid;
  const image::FloatImage image = Prepared(picture, grid, options);
  const double limit = image::LinearOfSrgb(options.threshold);
  const auto bright = std::count_if(image.values.begin(), image.values.end(),
                                    [&](float v) { return v >= limit; });
  const double area_mm2 = panel.width_mm * panel.height_mm * static_cast<double>(bright) /
                          static_cast<double>(image.values.size());
  distance_mm =
      std::max(distance_mm, std::sqrt(area_mm2 * options.layer_count /
                                      static_cast<double>(options.target_point_count)));
  return HalftoneGrid(panel.width_mm, panel.height_mm, distance_mm, false);
}

PanelPoints ScreenByThreshold(const HalftoneGrid& grid, double threshold) {
  const double limit = image::LinearOfSrgb(threshold) - 1e-6;  // rounding of the means
  PanelPoints points;
  for (int row = 0; row < grid.rows; ++row) {
    for (int column = 0; column < grid.columns; ++column) {
      const Vec2 p_mm = grid.At(column, row);
      if (grid.BrightnessAt(column, row) >= limit && grid.Contains(p_mm)) {
        points.push_back(p_mm);
      }
    }
  }
  return points;
}

std::vector<PanelPoints> Layers(const image::GreyImage& picture, const Panel& panel,
                                const HalftoneOptions& options) {
  HalftoneGrid grid =
      options.method == HalftoneMethod::kThreshold
          ? ThresholdGrid(picture, panel, options)
          : HalftoneGrid(panel.width_mm, panel.height_mm, options.vertex_distance_mm,
                         IsTriangular(options));
  const image::FloatImage image = Prepared(picture, grid, options);
  std::vector<PanelPoints> layers;
  double gain = 0;
  std::unique_ptr<HalftoneMask> mask;
  SettleOptions settle{options.settle_count,
                       options.vertex_distance_mm * kRoundingAllowance};
  if (options.layer_count > 1) {
    settle.reach_mm = kReachRatio * grid.LayerStagger(options.layer_count);
  }
  for (int layer = 0; layer < options.layer_count; ++layer) {
    grid.PlaceLayer(layer, options.layer_count, image);
    if (options.method == HalftoneMethod::kThreshold) {
      layers.push_back(ScreenByThreshold(grid, options.threshold));
      continue;
    }
    if (layer == 0) gain = GainFor(grid, options);
    const auto density = [&](float t) { return ShareOf(gain * t, layer, options); };
    const std::uint64_t seed = options.seed + static_cast<std::uint64_t>(layer);
    if (options.method == HalftoneMethod::kErrorDiffusion) {
      layers.push_back(ScreenByErrors(grid, density, seed));
      continue;
    }
    if (!mask) mask = std::make_unique<HalftoneMask>(options.seed);
    layers.push_back(ScreenByMask(grid, density, *mask, seed));
    Settle(grid, density, settle, layers.back());
  }
  return layers;
}

Error OutOfRange(const char* name, double value, double low, double high) {
  return {ErrorCode::kInvalidValue,
          fmt::format("{} must be {:g}..{:g}, is {:g}", name, low, high, value),
          fmt::format("{:g}", value)};
}

}  // namespace

std::vector<Error> CheckHalftone(const HalftoneOptions& options) {
  std::vector<Error> errors;
  const auto check = [&](const char* name, double value, double low, double high) {
    if (!(value >= low && value <= high)) {
      errors.push_back(OutOfRange(name, value, low, high));
    }
  };
  check("vertex_distance_mm", options.vertex_distance_mm, 0.01, 100);
  check("threshold", options.threshold, 0, 1);
  check("layer_count", options.layer_count, 1, 10);
  check("layer_distance_mm", options.layer_distance_mm, 0, 50);
  check("settle_count", options.settle_count, 0, 50);
  if (options.layer_count > 1 && options.layer_distance_mm < options.vertex_distance_mm) {
    errors.push_back(
        {ErrorCode::kInvalidValue,
         fmt::format(
             "layers {:g} mm apart are nearer than their points, {:g} mm: thinning would "
             "remove points and change the tone; set layer_distance_mm to {:g} or more",
             options.layer_distance_mm, options.vertex_distance_mm,
             options.vertex_distance_mm),
         fmt::format("{:g}", options.layer_distance_mm)});
  }
  const Status tone = CheckTone(options.tone);
  if (!tone) errors.push_back(tone.error());
  return errors;
}

double MaxHalftonePoints(const Panel& panel, const HalftoneOptions& options) {
  const double d = options.vertex_distance_mm;
  const double cell_mm2 = d * d * (IsTriangular(options) ? std::sqrt(0.75) : 1);
  return panel.width_mm * panel.height_mm / cell_mm2 * options.layer_count;
}

Result<std::unique_ptr<PointSource>> MakeHalftone(const image::GreyImage& picture,
                                                  const mesh::GlassFromModel& placement,
                                                  const HalftoneOptions& options) {
  const std::vector<Error> errors = CheckHalftone(options);
  if (!errors.empty()) return tl::unexpected(errors.front());
  const auto size =
      INTAGLIO_TRY(PanelSizeOf(picture, options.size, options.vertex_distance_mm));
  const auto panel = INTAGLIO_TRY(PlacePanel(size, placement));
  const double largest = MaxHalftonePoints(panel, options);
  INTAGLIO_TRY(CheckLayerPlaces(largest / options.layer_count));
  INTAGLIO_TRY(CheckCandidateCount(largest));

  SpacedCloud cloud;
  const std::vector<PanelPoints> layers = Layers(picture, panel, options);
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const double z_mm = static_cast<double>(i) * options.layer_distance_mm;
    for (const Vec2& p : layers[i]) cloud.Add(panel.ToGlass(p.x(), p.y(), z_mm), 0);
  }
  return MakeFixedPoints(std::move(cloud));
}

}  // namespace intaglio::discretize
