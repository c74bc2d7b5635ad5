#include "engrave/optics/fresnel.h"

#include <cmath>
#include <numbers>

#include "engrave/core/check.h"

namespace intaglio::optics {

double ReflectanceAtNormalIncidence(double refractive_index) {
  Require(refractive_index >= 1, "refractive_index must be at least 1, is {}",
          refractive_index);
  const double r = (refractive_index - 1) / (refractive_index + 1);
  return r * r;
}

double ReflectanceAtAngle(double refractive_index, double incidence_rad) {
  Require(refractive_index >= 1, "refractive_index must be at least 1, is {}",
          refractive_index);
  Require(incidence_rad >= 0 && incidence_rad <= std::numbers::pi / 2,
          "incidence_rad must be in 0..pi/2, is {}", incidence_rad);
  const double n = refractive_index;
  const double outside = std::cos(incidence_rad);
  const double sine = std::sin(incidence_rad) / n;
  const double inside = std::sqrt(1 - sine * sine);
  const double across = (outside - n * inside) / (outside + n * inside);
  const double along = (n * outside - inside) / (n * outside + inside);
  return 0.5 * (across * across + along * along);
}

}  // namespace intaglio::optics
