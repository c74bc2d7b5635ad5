// A ray aimed at the point S below the face, at the angle a to the axis with sin a = NA,
// crosses the face at r = S tan a and goes on at b with sin b = NA / n. It meets the axis
// at
//   D = r / tan b = S tan a / tan b,
// and with tan a = NA / sqrt(1 - NA^2), tan b = NA / sqrt(n^2 - NA^2):
//   S / D = sqrt(1 - NA^2) / sqrt(n^2 - NA^2), and 1 / n as NA -> 0.
// With the marginal rays at depth D the paraxial ones meet at n S = D n (S / D) <= D.

#include "engrave/optics/focus.h"

#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::optics {
namespace {

void RequireIndex(double refractive_index) {
  Require(refractive_index >= 1 && std::isfinite(refractive_index),
          "refractive_index must be at least 1, is {}", refractive_index);
}

void RequireRanges(double refractive_index, double numerical_aperture) {
  RequireIndex(refractive_index);
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

double ParaxialStagePerGlassRatio(double refractive_index) {
  RequireIndex(refractive_index);
  return 1 / refractive_index;
}

double StageDepthForFocus(double depth_in_glass_mm, double refractive_index,
                          double numerical_aperture) {
  return depth_in_glass_mm * StagePerGlassRatio(refractive_index, numerical_aperture);
}

double FocusDepthForStage(double stage_depth_mm, double refractive_index,
                          double numerical_aperture) {
  return stage_depth_mm / StagePerGlassRatio(refractive_index, numerical_aperture);
}

double ConeHalfAngleInGlassRad(double refractive_index, double numerical_aperture) {
  RequireRanges(refractive_index, numerical_aperture);
  return std::asin(numerical_aperture / refractive_index);
}

double ConeTangentInGlass(double refractive_index, double numerical_aperture) {
  RequireRanges(refractive_index, numerical_aperture);
  const double n = refractive_index;
  const double na = numerical_aperture;
  return na / std::sqrt(n * n - na * na);
}

double FocusSpreadAtDepthMm(double depth_in_glass_mm, double refractive_index,
                            double numerical_aperture) {
  const double paraxial_per_marginal =
      refractive_index * StagePerGlassRatio(refractive_index, numerical_aperture);
  return depth_in_glass_mm * (1 - paraxial_per_marginal);
}

}  // namespace intaglio::optics
