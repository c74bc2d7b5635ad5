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

double Reflectance(double refractive_index, double incidence_rad) {
  const double n = refractive_index;
  Require(n >= 1, "refractive_index must be at least 1, is {}", n);
  Require(incidence_rad >= 0 && incidence_rad <= std::numbers::pi / 2,
          "incidence_rad must be in 0..pi/2, is {}", incidence_rad);
  if (n == 1) return 0;  // no face; both equations would be 0/0 at grazing incidence
  const double sin_in = std::sin(incidence_rad);
  const double cos_in = std::cos(incidence_rad);
  // n times the cosine in the glass; sin_in / n is the sine there.
  const double n_cos_out = std::sqrt(n * n - sin_in * sin_in);
  const double across = (cos_in - n_cos_out) / (cos_in + n_cos_out);
  const double along = (n * n * cos_in - n_cos_out) / (n * n * cos_in + n_cos_out);
  return 0.5 * (across * across + along * along);
}

double TopFaceTransmittance(double refractive_index, double incidence_rad) {
  return 1 - Reflectance(refractive_index, incidence_rad);
}

LightBalance LightAtDepth(double refractive_index, double incidence_rad,
                          double absorption_per_mm, double path_mm) {
  Require(absorption_per_mm >= 0 && path_mm >= 0,
          "absorption_per_mm and path_mm must not be negative, are {} and {}",
          absorption_per_mm, path_mm);
  LightBalance balance;
  balance.reflected_ratio = Reflectance(refractive_index, incidence_rad);
  const double entered = 1 - balance.reflected_ratio;
  balance.absorbed_ratio = -entered * std::expm1(-absorption_per_mm * path_mm);
  balance.transmitted_ratio = entered - balance.absorbed_ratio;
  return balance;
}

}  // namespace intaglio::optics
