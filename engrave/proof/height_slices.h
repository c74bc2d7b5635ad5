#pragma once

// Bands without points around a model: the number of points in level slices of it, by the
// number that the area of the surface in the slice lets expect.

#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::proof {

/// A slice counts when at least this many points are expected in it: fewer vary by
/// themselves.
inline constexpr double kMinExpectedPoints = 40;
/// A slice with less of those expected than this is a band.
inline constexpr double kBandRatio = 0.5;

struct HeightSlices {
  double slice_mm = 0;            ///< thickness: half the mean distance of neighbours
  std::uint64_t slice_count = 0;  ///< of those that count
  std::uint64_t band_count = 0;   ///< of these, below kBandRatio
  double smallest_ratio = 0;      ///< of points to those expected; 1: as everywhere
  double smallest_low_mm = 0;     ///< where that slice begins, glass frame
};

/// Slices of slice_mm > 0 from the lowest corner up; `points_mm` as many to each mm^2 as
/// over all. A level face, and every point at its height, is in the slice that holds it.
/// Slices nearer to a level face that fills a slice than two thicknesses do not count:
/// the row of points at its rim keeps the next row away. Without a slice that counts,
/// slice_count is 0.
HeightSlices MeasureHeightSlices(const std::vector<mesh::TriangleMesh>& models,
                                 const PointList& points_mm, double slice_mm);

}  // namespace intaglio::proof
