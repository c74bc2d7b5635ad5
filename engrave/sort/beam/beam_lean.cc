#include "engrave/sort/beam/beam_lean.h"

#include <algorithm>
#include <cmath>

namespace intaglio::sort {

/// Each leaves a hundredth of the error at 15 degrees and 60 mm.
constexpr int kSteps = 3;

Vec2 BeamLean::UpwardAt(const Vec3& place_mm) const {
  const Vec2 across_mm = place_mm.head<2>() - axis_mm;
  const Vec2 in_air = across_mm.cwiseQuotient(pupil_mm);
  const double depth_mm = depth_ratio * (top_mm - place_mm.z());
  if (depth_mm <= 0) return -depth_ratio * in_air;
  const double n = refractive_index, bend = 1 - 1 / (n * n);
  Vec2 slopes = in_air;
  for (int step = 0; step < kSteps; ++step) {
    const double q = slopes.squaredNorm() * bend;
    const double h = depth_mm / (n * std::sqrt(1 + q) * (1 + 0.5 * q));
    slopes = across_mm.cwiseQuotient(pupil_mm + Vec2::Constant(0.5 * h * q));
  }
  return -depth_ratio / (n * std::sqrt(1 + slopes.squaredNorm() * bend)) * slopes;
}

double BeamLean::Steepest() const {
  return depth_ratio * widest_mm / pupil_mm.minCoeff();
}

}  // namespace intaglio::sort
