#pragma once

// The order Kdz to the letter of its source: Trochimczuk 2008 annex E. The next point is
// the remaining one of least
//   max(|dx|, |dy|) + K |dz|,   K one for dz > 0, another for dz < 0,
// found by looking at all of them. It fires through earlier cracks (engrave/sort/kdz.h
// says why) and is here to compare with what was measured on it.

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::sort {

/// The points in their order, from the lowest on (of equal ones the first).
/// N^2 / 2 comparisons.
inline PointList PublishedGreedy(const PointList& points_mm, double k_up, double k_down) {
  std::vector<double> x, y, z;
  for (const Vec3& p : points_mm) {
    x.push_back(p.x());
    y.push_back(p.y());
    z.push_back(p.z());
  }
  PointList path_mm;
  std::size_t next =
      static_cast<std::size_t>(std::min_element(z.begin(), z.end()) - z.begin());
  for (std::size_t left = points_mm.size(); left > 0; --left) {
    const double ax = x[next], ay = y[next], az = z[next];
    path_mm.emplace_back(ax, ay, az);
    for (auto* column : {&x, &y, &z}) (*column)[next] = (*column)[left - 1];
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i + 1 < left; ++i) {
      const double dz = z[i] - az;
      const double cost = std::max(std::abs(x[i] - ax), std::abs(y[i] - ay)) +
                          std::max(k_up * dz, -k_down * dz);
      if (cost >= least) continue;
      least = cost;
      next = i;
    }
  }
  return path_mm;
}

}  // namespace intaglio::sort
