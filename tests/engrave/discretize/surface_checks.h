#pragma once

// What sources of even points owe.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "engrave/discretize/spacing/point_source.h"
#include "engrave/discretize/spacing/thinning.h"
#include "tests/engrave/discretize/oracles.h"
#include "tests/engrave/discretize/source_checks.h"

namespace intaglio::discretize {

inline SpacedCloud PointsOf(const PointSource& source, const HeightRange& range = {}) {
  SpacedCloud cloud;
  const auto statistics = source.AddPoints(range, 2, {}, cloud);
  EXPECT_TRUE(statistics.has_value());
  if (statistics) {
    EXPECT_EQ(statistics->point_count, cloud.size());
  }
  return cloud;
}

/// The points that thinning keeps of all its points, at their own spacings.
inline SpacedCloud Thinned(const PointSource& source) {
  return Thin(PointsOf(source), {1e-3, 1, {}, source.Rise()});
}

/// Cuts at the heights, and at those of some of the points themselves.
inline void ExpectSameInRanges(const PointSource& source,
                               std::vector<double> heights_mm) {
  const SpacedCloud whole = PointsOf(source);
  ASSERT_GT(whole.size(), 0u);
  for (std::size_t i = 0; i < whole.size(); i += whole.size() / 5 + 1) {
    heights_mm.push_back(source.Rise().dot(whole.points_mm[i]));
  }
  ExpectSlabsAreTheWhole(source, heights_mm);
  for (const float own_mm : whole.spacing_mm) ASSERT_LE(own_mm, source.MaxSpacing());
}

struct Evenness {
  double smallest, mean, variation;  ///< of nearest distances; standard deviation by mean
};

inline Evenness EvennessOf(const PointList& points) {
  const std::vector<double> distances = NearestPoints(points).NeighbourDistances();
  Evenness e{distances.at(0), 0, 0};
  for (const double d : distances) {
    e.smallest = std::min(e.smallest, d);
    e.mean += d / static_cast<double>(distances.size());
  }
  for (const double d : distances) {
    e.variation += (d - e.mean) * (d - e.mean) / static_cast<double>(distances.size());
  }
  e.variation = std::sqrt(e.variation) / e.mean;
  return e;
}

}  // namespace intaglio::discretize
