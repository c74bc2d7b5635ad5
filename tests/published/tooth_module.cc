#include "tests/published/tooth_module.h"

#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::drive {

double AtPole1(const Harmonics& harmonics, double x0_rad) {
  double sum = 0;
  for (std::size_t n = 0; n < harmonics.size(); ++n)
    sum += harmonics[n] * std::cos(static_cast<double>(n) * x0_rad);
  Require(sum > 0, "a pole of {} at {} rad", sum, x0_rad);
  return sum;
}

double AtPole2(const Harmonics& harmonics, double x0_rad) {
  return AtPole1({harmonics[0], -harmonics[1], harmonics[2], -harmonics[3], harmonics[4]},
                 x0_rad);
}

// 1 / (1 + q cos x) = sum of (-q cos x)^n, the powers of the cosine as harmonics:
// cos^2 = (1 + cos 2x) / 2, cos^3 = (3 cos x + cos 3x) / 4,
// cos^4 = (3 + 4 cos 2x + cos 4x) / 8.
Harmonics ReluctanceOf(double constant_h, double first_h) {
  const double q = first_h / constant_h;
  Require(constant_h > 0 && q >= 0 && q < 1, "permeances {} and {}", constant_h, first_h);
  const double q2 = q * q, q3 = q2 * q, q4 = q2 * q2;
  return {(1 + q2 / 2 + 3 * q4 / 8) / constant_h, -(q + 3 * q3 / 4) / constant_h,
          (q2 + q4) / 2 / constant_h, -q3 / 4 / constant_h, q4 / 8 / constant_h};
}

double CoilFlux(const Harmonics& permeance, double coil_a, double x0_rad) {
  return 2 * coil_a / (1 / AtPole1(permeance, x0_rad) + 1 / AtPole2(permeance, x0_rad));
}

double MagnetFlux(const Harmonics& permeance, double magnet_a, double magnet_per_h,
                  double x0_rad) {
  Require(magnet_per_h >= 0, "a magnet of {} per H", magnet_per_h);
  return magnet_a /
         (magnet_per_h + 2 / (AtPole1(permeance, x0_rad) + AtPole2(permeance, x0_rad)));
}

}  // namespace intaglio::drive
