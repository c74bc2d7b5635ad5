#include "engrave/proof/cloud_quality.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "engrave/core/check.h"
#include "engrave/core/counted.h"
#include "engrave/proof/distinct_places.h"
#include "engrave/proof/point_tree.h"
#include "engrave/proof/surface.h"

namespace intaglio::proof {
namespace {

// A hole is reported when it is this many times wider than the distance of the points:
// the widest hole between sections that are twice as far apart as their points is not
// reported.
constexpr double kWideHole = 3;
// Level slices are compared when this part of the points lies on the surface.
constexpr double kOnSurface = 0.95;
// More bands than this part of the slices are layers, as sections have them.
constexpr double kFewBands = 0.05;
// Rows of points along the level edges of an upright wall leave a third of those expected
// in a slice; a seam leaves less than a seventh.
constexpr double kDarkRing = 0.25;

double ModelArea(const mesh::TriangleMesh& model) {
  double area_mm2 = 0;
  for (const mesh::Triangle& t : model.triangles) {
    area_mm2 +=
        AreaOf(Corners{model.vertices[t[0]], model.vertices[t[1]], model.vertices[t[2]]});
  }
  return area_mm2;
}

std::vector<SourceShare> SharesOf(const PointCloud& cloud,
                                  const std::vector<double>& areas_mm2) {
  std::map<std::uint32_t, std::uint64_t> counts;
  for (const std::uint32_t source : cloud.source) ++counts[source];
  for (std::uint32_t i = 0; i < areas_mm2.size(); ++i) counts.try_emplace(i, 0);
  double area_mm2 = 0;
  for (const double area : areas_mm2) area_mm2 += area;
  std::vector<SourceShare> shares;
  for (const auto& [source, count] : counts) {
    SourceShare share{source, count,
                      static_cast<double>(count) / static_cast<double>(cloud.size()),
                      std::nullopt};
    if (source < areas_mm2.size() && area_mm2 > 0) {
      share.surface_ratio = areas_mm2[source] / area_mm2;
    }
    shares.push_back(share);
  }
  return shares;
}

SurfaceQuality QualityOnSurface(const DistinctPlaces& places, const PointTree& tree,
                                const std::vector<mesh::TriangleMesh>& models,
                                double area_mm2, double mean_mm,
                                const QualityOptions& options) {
  SurfaceQuality quality;
  for (const mesh::TriangleMesh& model : models) {
    quality.triangle_count += model.triangles.size();
  }
  const SurfaceDensityOptions density_options{.reach_mm = 0.5 * options.min_spacing_mm,
                                              .executor = options.executor};
  const std::size_t count = places.places_mm.size();
  // Without an area there is nothing to cut.
  const double piece_mm2 =
      area_mm2 > 0 ? PieceArea(area_mm2, count, density_options) : 1.0;
  const Surface surface(models, piece_mm2, 4 * count + 4096);
  quality.uncovered =
      LargestUncoveredDisc(surface, tree, places.places_mm, options.executor);
  quality.density = MeasureSurfaceDensity(surface, places.places_mm, density_options);
  const double on_surface = static_cast<double>(quality.density.on_surface_count);
  if (mean_mm > 0 && on_surface >= kOnSurface * static_cast<double>(count)) {
    const HeightSlices slices =
        MeasureHeightSlices(models, places.places_mm, 0.5 * mean_mm);
    if (slices.slice_count > 0) quality.slices = slices;
  }
  quality.farthest_mm = places.places_mm[quality.density.farthest_point];
  quality.density_ratio = quality.density.points_per_mm2 * options.min_spacing_mm *
                          options.min_spacing_mm * std::numbers::sqrt3 / 2;
  return quality;
}

std::string At(const Vec3& p_mm) {
  return fmt::format("({:.2f}, {:.2f}, {:.2f}) mm", p_mm.x(), p_mm.y(), p_mm.z());
}

void WarnOfSpacing(const QualityOptions& options, CloudQuality& quality) {
  const NearestDistances& nearest = quality.nearest;
  if (nearest.doubled_count > 0) {
    quality.warnings.push_back(MakeWarning(
        WarningCode::kDoubledPoints,
        fmt::format("{} {} the same place as another one, e.g. at {}: thin the cloud",
                    Counted(nearest.doubled_count, "point"),
                    HasOrHave(nearest.doubled_count), At(nearest.smallest.first_mm))));
  } else if (nearest.near_pair_count > 0) {
    const bool scaled = options.height_ratio != 1;
    const std::uint64_t at_least = nearest.near_pair_count + (nearest.more_pairs ? 1 : 0);
    quality.warnings.push_back(MakeWarning(
        WarningCode::kNearPoints,
        fmt::format(
            "{}{} {} of points {} nearer than the minimum spacing of {:g} mm{}, the "
            "nearest {:.6f} mm at {}: thin the cloud with that spacing",
            nearest.near_pair_count, nearest.more_pairs ? " or more" : "",
            NounFor(at_least, "pair"), IsOrAre(at_least), options.min_spacing_mm,
            scaled ? fmt::format(" (heights divided by {:g})", options.height_ratio) : "",
            nearest.min_scaled.distance_mm, At(nearest.min_scaled.first_mm))));
  }
}

void WarnOfHoles(CloudQuality& quality) {
  if (!quality.surface) return;
  const UncoveredDisc& hole = quality.surface->uncovered;
  const double usual_mm = quality.nearest.mean_mm;
  if (quality.point_count > 1 && hole.radius_mm <= kWideHole * usual_mm) return;
  quality.warnings.push_back(MakeWarning(
      WarningCode::kHole,
      fmt::format(
          "the surface has a hole of radius {:.2f} mm at {}, where points are {:.2f} mm "
          "apart on average: a face parallel to the sections or rays has no points, or "
          "the "
          "model hides it; fill such faces, or use the method even",
          hole.radius_mm, At(hole.place_mm), usual_mm)));
}

void WarnOfBands(CloudQuality& quality) {
  if (!quality.surface || !quality.surface->slices) return;
  const HeightSlices& slices = *quality.surface->slices;
  const double few = kFewBands * static_cast<double>(slices.slice_count);
  if (slices.smallest_ratio >= kDarkRing) return;
  if (static_cast<double>(slices.band_count) > few) return;
  const double low_mm = slices.smallest_low_mm;
  quality.warnings.push_back(MakeWarning(
      WarningCode::kHole,
      fmt::format(
          "a band around the model has too few points: {:.0f} % of those expected "
          "between the heights {:.2f} and {:.2f} mm, below {:.0f} % in {} of {}; "
          "it shows as a dark ring: make the cloud again with the method "
          "even",
          100 * slices.smallest_ratio, low_mm, low_mm + slices.slice_mm, 100 * kBandRatio,
          slices.band_count, Counted(slices.slice_count, "slice"))));
}

void WarnOfCracks(const QualityOptions& options, CloudQuality& quality) {
  if (!quality.crack_risk || quality.crack_risk->worst.empty()) return;
  const CrackRisk& risk = *quality.crack_risk;
  const DensePlace& worst = risk.worst.front();
  std::string others;
  for (std::size_t i = 1; i < risk.worst.size(); ++i) {
    others += (i == 1 ? ", also at " : ", ") + At(risk.worst[i].place_mm);
  }
  // In a ball of one size the count falls with the square of the spacing on sheets, and
  // faster in solids.
  const double wider = std::sqrt(worst.crack_share / risk.max_share);
  const double spacing_mm = std::ceil(wider * options.min_spacing_mm * 100) / 100;
  quality.warnings.push_back(MakeWarning(
      WarningCode::kBreakage,
      fmt::format("the glass may break at {}{}: {:.0f} points per mm^3, cracks take "
                  "{:.0f} % of the volume, {:.0f} % is safe; set a minimum spacing of "
                  "{:.2f} mm, or remove overlapping parts there",
                  At(worst.place_mm), others, worst.points_per_mm3,
                  100 * worst.crack_share, 100 * risk.max_share, spacing_mm)));
}

}  // namespace

Result<CloudQuality> MeasureCloud(const PointCloud& cloud,
                                  const std::vector<mesh::TriangleMesh>& models,
                                  const QualityOptions& options) {
  Require(options.min_spacing_mm > 0, "min_spacing_mm is {}", options.min_spacing_mm);
  Require(cloud.source.size() == cloud.size(), "{} points of {} sources", cloud.size(),
          cloud.source.size());
  if (cloud.size() == 0) {
    return Fail(ErrorCode::kMissing, "the cloud has no points to measure");
  }
  std::vector<double> areas_mm2;
  bool has_triangles = false;
  for (const mesh::TriangleMesh& model : models) {
    areas_mm2.push_back(ModelArea(model));
    has_triangles = has_triangles || !model.triangles.empty();
  }
  if (!models.empty() && !has_triangles) {
    return Fail(ErrorCode::kMissing, "the models have no triangles: leave them out");
  }
  CloudQuality quality;
  quality.point_count = cloud.size();
  for (const Vec3& p : cloud.points_mm) quality.bounds_mm.Extend(p);
  const DistinctPlaces places = DistinctPlacesOf(cloud.points_mm);
  const PointTree tree(places.places_mm);
  quality.nearest = MeasureNearest(
      places, tree, {options.min_spacing_mm, options.height_ratio, options.executor});
  quality.histogram = HistogramOf(quality.nearest.distance_mm, options.min_spacing_mm);
  quality.sources = SharesOf(cloud, areas_mm2);
  if (has_triangles) {
    double area_mm2 = 0;
    for (const double area : areas_mm2) area_mm2 += area;
    quality.surface = QualityOnSurface(places, tree, models, area_mm2,
                                       quality.nearest.mean_mm, options);
  }
  const CrackRiskOptions crack_options{.crack_diameter_mm = options.crack_diameter_mm,
                                       .crack_length_mm = options.crack_length_mm,
                                       .executor = options.executor};
  if (options.crack_diameter_mm > 0 && options.crack_length_mm > 0) {
    quality.crack_risk = MeasureCrackRisk(places, tree, crack_options);
  }
  WarnOfSpacing(options, quality);
  WarnOfHoles(quality);
  WarnOfBands(quality);
  WarnOfCracks(options, quality);
  return quality;
}

}  // namespace intaglio::proof
