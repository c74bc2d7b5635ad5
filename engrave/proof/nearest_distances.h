#pragma once

// How far the points of a cloud are from one another: for every point the distance to
// the nearest other one, and the pairs that are too near. Measured with a k-d tree of
// its own, not with what made the cloud.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engrave/core/executor.h"
#include "engrave/core/geometry.h"
#include "engrave/proof/distinct_places.h"
#include "engrave/proof/point_tree.h"

namespace intaglio::proof {

/// Pairs nearer than the minimum spacing by less than this are not too near: it is the
/// rounding of coordinates, which also spoils a lattice of exactly that spacing.
inline constexpr double kSpacingToleranceMm = 1e-9;

struct NearestOptions {
  double min_spacing_mm = 0;  ///< >= 0; 0: no pair is too near
  /// >= 1: heights count only by this part of them, as cracks are longer than wide.
  double height_ratio = 1;
  Executor executor = {};
};

struct NearestPair {
  std::uint32_t first_point = 0, second_point = 0;
  double distance_mm = 0;
  Vec3 first_mm = Vec3::Zero(), second_mm = Vec3::Zero();
};

struct NearestDistances {
  /// To the nearest other point; infinite for a point that is alone.
  std::vector<double> distance_mm;

  // Of these distances; all 0 with fewer than two points.
  NearestPair smallest;
  double mean_mm = 0;
  double variation_ratio = 0;  ///< standard deviation over mean
  double largest_mm = 0;

  std::uint64_t doubled_count = 0;  ///< points at the place of an earlier one

  // In distances with heights divided by height_ratio.
  NearestPair min_scaled;              ///< its distance_mm is in this measure
  std::uint64_t near_point_count = 0;  ///< that have another one too near
  std::uint64_t near_pair_count = 0;
  /// There are more pairs than that: for a place with thousands of points too near not
  /// all are counted.
  bool more_pairs = false;
};

/// `places` are those of the cloud, `tree` is of them. Finite, glass frame, mm. The same
/// for any executor.
NearestDistances MeasureNearest(const DistinctPlaces& places, const PointTree& tree,
                                const NearestOptions& options);

struct Histogram {
  double bin_mm = 0;                  ///< bin i spans i * bin_mm .. (i + 1) * bin_mm
  std::vector<std::uint64_t> counts;  ///< the last one holds all that is wider, too
};

/// 60 bins of distances from 0 to three times `unit_mm` > 0.
Histogram HistogramOf(const std::vector<double>& distance_mm, double unit_mm);

}  // namespace intaglio::proof
