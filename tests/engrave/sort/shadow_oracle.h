#pragma once

// How many points of an order are fired through an earlier crack: by the product's count
// of points in the order of engraving, and by the definition.

#include <cmath>
#include <cstdint>

#include "engrave/core/geometry.h"
#include "engrave/sort/beam/beam_cone.h"
#include "engrave/sort/order.h"
#include "engrave/sort/shadow.h"

namespace intaglio::sort {

/// The points of an order of all or some of them; one that names another point throws.
inline PointList InOrder(const PointList& points_mm, const Order& order) {
  PointList made_mm;
  for (const std::uint32_t i : order) made_mm.push_back(points_mm.at(i));
  return made_mm;
}

inline std::uint64_t CountShadowViolations(const PointList& points_mm, const Order& order,
                                           const BeamCone& cone) {
  return CountShadowViolations(InOrder(points_mm, order), cone);
}

/// Every pair compared.
inline std::uint64_t CountShadowViolationsBruteForce(const PointList& made_mm,
                                                     const BeamCone& cone) {
  std::uint64_t violations = 0;
  for (std::size_t made = 0; made < made_mm.size(); ++made) {
    bool violated = false;
    for (std::size_t earlier = 0; earlier < made && !violated; ++earlier) {
      const Vec3 d = made_mm[earlier] - made_mm[made];
      const Vec2 axis_mm = d.z() * cone.LeanAt(made_mm[made]);
      violated = cone.Shades((d.head<2>() - axis_mm).norm(), d.z());
    }
    violations += violated;
  }
  return violations;
}

}  // namespace intaglio::sort
