#include "engrave/discretize/picture/relief.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/discretize/picture/relief_surface.h"
#include "engrave/discretize/spacing/fixed_points.h"

namespace intaglio::discretize {
namespace {

int PixelsFor(double length_mm, double pixel_mm, int largest) {
  return std::clamp(static_cast<int>(std::lround(length_mm / pixel_mm)), 1, largest);
}

ReliefSurface SurfaceOf(const image::GreyImage& map, const Panel& panel,
                        const ReliefOptions& options) {
  // A quarter of a distance: finer, nothing can be shown.
  const double pixel_mm = std::max(options.smoothing_mm, options.vertex_distance_mm / 4);
  ReliefSurface surface;
  surface.map = image::Resample(map, PixelsFor(panel.width_mm, pixel_mm, map.width),
                                PixelsFor(panel.height_mm, pixel_mm, map.height));
  surface.width_mm = panel.width_mm;
  surface.height_mm = panel.height_mm;
  const double depth_mm = options.depth_mm * panel.depth_ratio;
  surface.low_mm = options.white_is_near ? 0 : depth_mm;
  surface.high_mm = options.white_is_near ? depth_mm : 0;
  return surface;
}

}  // namespace

std::vector<Error> CheckRelief(const ReliefOptions& options) {
  std::vector<Error> errors;
  const auto check = [&](const char* name, double value, double low, double high) {
    if (value >= low && value <= high) return;
    errors.push_back(
        {ErrorCode::kInvalidValue,
         fmt::format("{} must be {:g}..{:g}, is {:g}", name, low, high, value),
         fmt::format("{:g}", value)});
  };
  check("depth_mm", options.depth_mm, 0, 500);
  check("smoothing_mm", options.smoothing_mm, 0, 10);
  check("vertex_distance_mm", options.vertex_distance_mm, 0.01, 100);
  check("layer_count", options.layer_count, 1, 10);
  check("layer_distance_mm", options.layer_distance_mm, 0, 50);
  if (options.layer_count > 1) {
    check("layer_distance_mm of several layers", options.layer_distance_mm,
          options.vertex_distance_mm, 50);
  }
  const Status tone = CheckTone(options.tone);
  if (!tone) errors.push_back(tone.error());
  return errors;
}

Result<std::unique_ptr<PointSource>> MakeRelief(
    const image::GreyImage& depth_map, const std::optional<image::GreyImage>& photo,
    const mesh::GlassFromModel& placement, const ReliefOptions& options) {
  const std::vector<Error> errors = CheckRelief(options);
  if (!errors.empty()) return tl::unexpected(errors.front());
  const double d = options.vertex_distance_mm;
  const auto size = INTAGLIO_TRY(PanelSizeOf(depth_map, options.size, d));
  const auto panel = INTAGLIO_TRY(PlacePanel(size, placement));
  INTAGLIO_TRY(CheckLayerPlaces(panel.width_mm * panel.height_mm / (d * d)));
  const ReliefSurface surface = SurfaceOf(depth_map, panel, options);
  const std::vector<float> areas = SurfaceAreas(surface, d);
  const double steep = std::accumulate(areas.begin(), areas.end(), 0.0) / (d * d);
  INTAGLIO_TRY(CheckLayerPlaces(steep * options.layer_count));

  image::FloatImage light{1, 1, {1}};
  if (photo) {
    light = image::Resample(*photo, PixelsFor(panel.width_mm, d, photo->width),
                            PixelsFor(panel.height_mm, d, photo->height));
    ApplyTone(options.tone, light);
  }
  const double apart_mm = d * kRoundingAllowance;
  const std::vector<PointList> layers = SpreadPoints(
      surface, apart_mm, options.layer_count, options.layer_distance_mm, options.seed);
  SpacedCloud cloud;
  for (const PointList& points : layers) {
    const std::vector<float> ranks = EvenRanks(points, apart_mm, options.seed);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3& p = points[i];
      const float brightness =
          image::Interpolate(light, p.x() / panel.width_mm, 1 - p.y() / panel.height_mm);
      if (ranks[i] < brightness) cloud.Add(panel.ToGlass(p.x(), p.y(), p.z()), 0);
    }
  }
  return MakeFixedPoints(std::move(cloud));
}

}  // namespace intaglio::discretize
