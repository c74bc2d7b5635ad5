// A ray aimed at the point S below the face, at the angle a to the axis with sin a = NA,
// crosses the face at r = S tan a and goes on at b with sin b = NA / n. It meets the axis
// at
//   D = r / tan b = S tan a / tan b,
// and with tan a = NA / sqrt(1 - NA^2), tan b = NA / sqrt(n^2 - NA^2):
//   S / D = sqrt(1 - NA^2) / sqrt(n^2 - NA^2), and 1 / n as NA -> 0.

#include "engrave/optics/focus.h"

#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::optics {
namespace {

void RequireRanges(double refractive_index, double numerical_aperture) {
  Require(refractive_index >= 1 && std::isfinite(refractive_index),
          "refractive_index must be at least 1, is {}", refractive_index);
  Require(numerical_aperture > 0 && numerical_aperture < 1,
          "numerical_aperture must be between 0 and 1, is {}", numerical_aperture);
}

}  // namespace

double StagePerGlassRatio(double refractive_index, double numerical_aperture) {
  RequireRanges(refractive_index, numerical_aperture);
  const double n = refractive_index;
  const double na = numerical_aperture;
  return std::sqrt((1 - na * na) / (n * n - na * na));
}

double RefractiveIndexOf(double stage_per_glass_ratio, double numerical_aperture) {
  Require(stage_per_glass_ratio > 0 && stage_per_glass_ratio <= 1,
          "stage_per_glass_ratio must be in 0..1, is {}", stage_per_glass_ratio);
  const double na = numerical_aperture;
  return std::sqrt(na * na +
                   (1 - na * na) / (stage_per_glass_ratio * stage_per_glass_ratio));
}

// For the marginal rays to meet at d the stage moves s = d StagePerGlassRatio; paraxial
// rays meet at n s then, which is less.
double FocusSpreadMm(double refractive_index, double numerical_aperture,
                     double depth_mm) {
  Require(depth_mm >= 0, "depth_mm must not be negative, is {}", depth_mm);
  const double stage = StagePerGlassRatio(refractive_index, numerical_aperture);
  return depth_mm * (1 - refractive_index * stage);
}

double ConeTangentInGlass(double refractive_index, double numerical_aperture) {
  RequireRanges(refractive_index, numerical_aperture);
  const double n = refractive_index;
  const double na = numerical_aperture;
  return na / std::sqrt(n * n - na * na);
}

}  // namespace intaglio::optics
