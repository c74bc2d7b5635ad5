#pragma once

// Points spread evenly over a surface above a panel, and an order of them in which every
// beginning is even too.

#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/image/resample.h"

namespace intaglio::discretize {

/// z = depth(x, y) over [0, width] x [0, height], mm, y up: straight lines between the
/// middles of the map's pixels.
struct ReliefSurface {
  image::FloatImage map;  ///< 0..1
  double width_mm = 0, height_mm = 0;
  double low_mm = 0, high_mm = 0;  ///< z of the map's 0 and 1

  double DepthAt(double x_mm, double y_mm) const {
    const float v = image::Interpolate(map, x_mm / width_mm, 1 - y_mm / height_mm);
    return low_mm + (high_mm - low_mm) * static_cast<double>(v);
  }
};

/// mm^2 of surface over every square of `side_mm`, from the lower left, row by row.
std::vector<float> SurfaceAreas(const ReliefSurface& surface, double side_mm);

/// A Poisson-disk set on each of `layer_count` copies of the surface, each layer_distance
/// further along z: no two points of all are nearer than `distance_mm` (exactly, in
/// space), and hardly any further point would fit. Seeded.
std::vector<PointList> SpreadPoints(const ReliefSurface& surface, double distance_mm,
                                    int layer_count, double layer_distance_mm,
                                    std::uint64_t seed);

/// 0..1 a point: those with a value below t are the share t of the points, evenly spread
/// themselves.
std::vector<float> EvenRanks(const PointList& points, double distance_mm,
                             std::uint64_t seed);

}  // namespace intaglio::discretize
