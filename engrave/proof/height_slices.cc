#include "engrave/proof/height_slices.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engrave/core/check.h"
#include "engrave/proof/surface.h"

// The area of a triangle in a slice: the length of its cut at height z rises linearly
// from the lowest corner to the middle one and falls linearly to the highest. With
// lengths as parts of the longest one, all of the area is (highest - lowest) / 2, and the
// area between two heights on one of the two lines is the mean length by the difference
// of height.

namespace intaglio::proof {
namespace {

// Corners so near in height make a level face, and points so near to it lie on it.
constexpr double kLevelMm = 1e-6;
// No slice of a million shows anything.
constexpr double kMaxSlices = 1e6;

class Slices {
 public:
  Slices(const Box3& bounds, double slice_mm)
      : base_mm_(bounds.min_mm.z()), slice_mm_(slice_mm) {
    const double count = bounds.size_mm().z() / slice_mm + 1;
    area_mm2_.assign(static_cast<std::size_t>(std::min(count, kMaxSlices)), 0);
    level_mm2_ = points_ = area_mm2_;
  }

  void Add(const Corners& corners) {
    std::array<double, 3> z = {corners[0].z(), corners[1].z(), corners[2].z()};
    std::sort(z.begin(), z.end());
    const double area_mm2 = AreaOf(corners);
    if (z[2] - z[0] < kLevelMm) {
      levels_mm_.push_back(z[0]);
      level_mm2_[Of(z[0])] += area_mm2;
      area_mm2_[Of(z[0])] += area_mm2;
      return;
    }
    for (std::size_t i = Of(z[0]); i <= Of(z[2]); ++i) {
      const double low = i == Of(z[0]) ? z[0] : Low(i);
      const double high = i == Of(z[2]) ? z[2] : Low(i + 1);
      area_mm2_[i] += area_mm2 * (PartOf(z, low, std::min(high, z[1])) +
                                  PartOf(z, std::max(low, z[1]), high));
    }
  }

  void Count(const PointList& points_mm) {
    std::sort(levels_mm_.begin(), levels_mm_.end());
    for (const Vec3& p : points_mm) {
      const auto level =
          std::lower_bound(levels_mm_.begin(), levels_mm_.end(), p.z() - kLevelMm);
      const bool on_it = level != levels_mm_.end() && *level <= p.z() + kLevelMm;
      points_[Of(on_it ? *level : p.z())] += 1;
    }
  }

  HeightSlices Measure() const {
    double all_mm2 = 0, all_points = 0;
    for (const double area_mm2 : area_mm2_) all_mm2 += area_mm2;
    for (const double points : points_) all_points += points;
    const double points_per_mm2 = all_mm2 > 0 ? all_points / all_mm2 : 0;
    HeightSlices found{.slice_mm = slice_mm_,
                       .smallest_ratio = std::numeric_limits<double>::infinity()};
    for (std::size_t i = 0; i < area_mm2_.size(); ++i) {
      const double expected = points_per_mm2 * area_mm2_[i];
      if (expected < kMinExpectedPoints || IsNearLevelFace(i, points_per_mm2)) continue;
      ++found.slice_count;
      const double ratio = points_[i] / expected;
      found.band_count += ratio < kBandRatio ? 1 : 0;
      if (ratio >= found.smallest_ratio) continue;
      found.smallest_ratio = ratio;
      found.smallest_low_mm = Low(i);
    }
    if (found.slice_count == 0) found.smallest_ratio = 0;
    return found;
  }

 private:
  double Low(std::size_t i) const {
    return base_mm_ + slice_mm_ * static_cast<double>(i);
  }
  std::size_t Of(double z_mm) const {
    const double at = std::max(0.0, (z_mm - base_mm_) / slice_mm_);
    return std::min(static_cast<std::size_t>(at), area_mm2_.size() - 1);
  }

  /// The share of a triangle's area between heights that the middle corner does not
  /// separate; 0 when `low` is not below `high`.
  static double PartOf(const std::array<double, 3>& z, double low, double high) {
    if (!(low < high)) return 0;
    const auto length = [&](double at) {
      return at <= z[1] && z[1] > z[0] ? (at - z[0]) / (z[1] - z[0])
                                       : (z[2] - at) / (z[2] - z[1]);
    };
    return (length(low) + length(high)) * (high - low) / (z[2] - z[0]);
  }

  bool IsNearLevelFace(std::size_t i, double points_per_mm2) const {
    const std::size_t end = std::min(i + 3, area_mm2_.size());
    for (std::size_t k = i < 2 ? 0 : i - 2; k < end; ++k) {
      if (level_mm2_[k] * points_per_mm2 >= kMinExpectedPoints) return true;
    }
    return false;
  }

  double base_mm_, slice_mm_;
  std::vector<double> area_mm2_, level_mm2_, points_;  // of each slice
  std::vector<double> levels_mm_;
};

}  // namespace

HeightSlices MeasureHeightSlices(const std::vector<mesh::TriangleMesh>& models,
                                 const PointList& points_mm, double slice_mm) {
  Require(slice_mm > 0, "slice_mm must be positive, is {}", slice_mm);
  Box3 bounds;
  for (const mesh::TriangleMesh& model : models) {
    for (const mesh::Triangle& t : model.triangles) {
      for (const std::uint32_t corner : t) bounds.Extend(model.vertices[corner]);
    }
  }
  if (bounds.empty()) return {.slice_mm = slice_mm};
  Slices slices(bounds, slice_mm);
  for (const mesh::TriangleMesh& model : models) {
    for (const mesh::Triangle& t : model.triangles) {
      slices.Add({model.vertices[t[0]], model.vertices[t[1]], model.vertices[t[2]]});
    }
  }
  slices.Count(points_mm);
  return slices.Measure();
}

}  // namespace intaglio::proof
