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
}

}  // namespace intaglio::sort
