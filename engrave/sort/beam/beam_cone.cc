#include "engrave/sort/beam/beam_cone.h"

#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::sort {

void RequireUsable(const BeamCone& cone) {
  Require(cone.tangent >= 0 && std::isfinite(cone.tangent),
          "the beam cone's tangent must not be negative, is {}", cone.tangent);
  Require(cone.crack_radius_mm >= 0 && std::isfinite(cone.crack_radius_mm),
          "crack_radius_mm must not be negative, is {}", cone.crack_radius_mm);
  Require(cone.crack_length_mm > 0 && std::isfinite(cone.crack_length_mm),
          "crack_length_mm must be positive, is {}", cone.crack_length_mm);
  if (!cone.lean) return;
  const BeamLean& lean = *cone.lean;
  Require((lean.pupil_mm.array() > 0).all(), "pupil_mm must be positive, is {} and {}",
          lean.pupil_mm.x(), lean.pupil_mm.y());
  Require(lean.refractive_index >= 1 && lean.depth_ratio > 0 && lean.widest_mm >= 0,
          "a lean of refractive_index {}, depth_ratio {} and widest_mm {}",
          lean.refractive_index, lean.depth_ratio, lean.widest_mm);
}

}  // namespace intaglio::sort
