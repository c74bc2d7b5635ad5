#include "engrave/proof/surface_density.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engrave/core/check.h"

namespace intaglio::proof {
namespace {

constexpr std::size_t kPointsPerTask = 8192;
// Patches consist of whole pieces: the smaller the pieces, the more equal the patches.
constexpr double kPiecesPerPatch = 8;

/// The farthest of a task's points.
struct Farthest {
  double square_mm2 = -1, on_surface_square_mm2 = 0;
  std::uint32_t point = 0;

  void Receive(double square, std::uint32_t at, double reach_square) {
    if (square > square_mm2) {
      square_mm2 = square;
      point = at;
    }
    if (square <= reach_square) {
      on_surface_square_mm2 = std::max(on_surface_square_mm2, square);
    }
  }
};

/// Counts the points on every triangle.
std::vector<std::uint32_t> CountOnTriangles(const Surface& surface,
                                            const PointList& points_mm,
                                            const SurfaceDensityOptions& options,
                                            SurfaceDensity& result) {
  constexpr std::uint32_t kNone = 0xFFFFFFFF;
  std::vector<std::uint32_t> triangle_of(points_mm.size());
  std::vector<Farthest> farthest((points_mm.size() + kPointsPerTask - 1) /
                                 kPointsPerTask);
  const double reach_square = options.reach_mm * options.reach_mm;
  RunEach(options.executor, farthest.size(), [&](std::size_t task) {
    const std::size_t end = std::min(points_mm.size(), (task + 1) * kPointsPerTask);
    std::uint32_t last = 0;
    for (std::size_t i = task * kPointsPerTask; i < end; ++i) {
      const Surface::Place place = surface.NearestTo(points_mm[i], last);
      last = place.triangle;
      triangle_of[i] = place.square_mm2 <= reach_square ? place.triangle : kNone;
      farthest[task].Receive(place.square_mm2, static_cast<std::uint32_t>(i),
                             reach_square);
    }
  });
  Farthest all;
  for (const Farthest& part : farthest) {
    if (part.square_mm2 > all.square_mm2) {
      all.square_mm2 = part.square_mm2;
      all.point = part.point;
    }
    all.on_surface_square_mm2 =
        std::max(all.on_surface_square_mm2, part.on_surface_square_mm2);
  }
  result.greatest_distance_mm = std::sqrt(all.square_mm2);
  result.farthest_point = all.point;
  result.greatest_on_surface_mm = std::sqrt(all.on_surface_square_mm2);
  std::vector<std::uint32_t> counts(surface.triangles().size(), 0);
  for (const std::uint32_t triangle : triangle_of) {
    if (triangle == kNone) continue;
    ++counts[triangle];
    ++result.on_surface_count;
  }
  return counts;
}

struct Patch {
  double area_mm2 = 0;
  std::uint64_t points = 0;
};

/// Runs of triangles in the tree's order, which are about as wide as long.
std::vector<Patch> PatchesOf(const Surface& surface,
                             const std::vector<std::uint32_t>& counts, double area_mm2,
                             std::size_t patch_count) {
  std::vector<Patch> patches(patch_count);
  double before_mm2 = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double own_mm2 = AreaOf(surface.triangles()[i]);
    const double share = (before_mm2 + 0.5 * own_mm2) / area_mm2;
    before_mm2 += own_mm2;
    const auto at = static_cast<std::size_t>(share * static_cast<double>(patch_count));
    Patch& patch = patches[std::min(at, patch_count - 1)];
    patch.area_mm2 += own_mm2;
    patch.points += counts[i];
  }
  return patches;
}

}  // namespace

double PieceArea(double area_mm2, std::uint64_t point_count,
                 const SurfaceDensityOptions& options) {
  const double patches = std::max(1.0, static_cast<double>(point_count) /
                                           static_cast<double>(options.points_per_patch));
  return area_mm2 / (kPiecesPerPatch * patches);
}

SurfaceDensity MeasureSurfaceDensity(const Surface& surface, const PointList& points_mm,
                                     const SurfaceDensityOptions& options) {
  Require(options.reach_mm > 0 && options.points_per_patch > 0,
          "reach_mm is {}, points_per_patch {}", options.reach_mm,
          options.points_per_patch);
  Require(!points_mm.empty(), "there are no points to measure");
  SurfaceDensity result;
  for (const Corners& triangle : surface.triangles()) result.area_mm2 += AreaOf(triangle);
  const auto counts = CountOnTriangles(surface, points_mm, options, result);
  if (result.area_mm2 <= 0 || result.on_surface_count == 0) return result;
  const auto on_surface = static_cast<double>(result.on_surface_count);
  result.points_per_mm2 = on_surface / result.area_mm2;
  result.patch_count =
      std::max<std::uint64_t>(1, result.on_surface_count / options.points_per_patch);
  double squares = 0;
  for (const Patch& patch : PatchesOf(surface, counts, result.area_mm2,
                                      static_cast<std::size_t>(result.patch_count))) {
    if (patch.area_mm2 <= 0) continue;
    const double excess =
        static_cast<double>(patch.points) / patch.area_mm2 - result.points_per_mm2;
    squares += patch.area_mm2 * excess * excess;
    if (patch.points == 0) ++result.empty_patch_count;
  }
  result.variation_ratio = std::sqrt(squares / result.area_mm2) / result.points_per_mm2;
  return result;
}

}  // namespace intaglio::proof
