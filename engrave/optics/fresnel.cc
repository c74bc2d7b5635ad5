#include "engrave/optics/fresnel.h"

#include "engrave/core/check.h"

namespace intaglio::optics {

double ReflectanceAtNormalIncidence(double refractive_index) {
  Require(refractive_index >= 1, "refractive_index must be at least 1, is {}",
          refractive_index);
  const double r = (refractive_index - 1) / (refractive_index + 1);
  return r * r;
}

}  // namespace intaglio::optics
