#include "services/virtual_engraver/mechanics/vibration.h"

#include <algorithm>
#include <cmath>
#include <numbers>

// The acceleration is the second difference of the places, over steps that may differ:
// the mean of both steps lies between the middles in which the speeds are. Over a step it
// is taken as constant, and the oscillation is integrated by the midpoint rule.

namespace intaglio::virtual_engraver {
namespace {

// Longer than this the acceleration of a step is no longer one number.
constexpr double kRatioOfPeriod = 0.02;

}  // namespace

void Vibration::Follow(const Vec3& actual_mm, double step_s) {
  const Vec3 speed_mm_s = (actual_mm - last_mm_) / step_s;
  const double between_s = last_step_s_ > 0 ? 0.5 * (step_s + last_step_s_) : step_s;
  const Vec3 acceleration = (speed_mm_s - last_mm_s_) / between_s;
  last_mm_ = actual_mm;
  last_mm_s_ = speed_mm_s;
  last_step_s_ = step_s;
  const Vec3 bound = Vec3::Constant(options_.above_mm_s2);
  const Vec3 excess = acceleration - acceleration.cwiseMax(-bound).cwiseMin(bound);
  if (excess.isZero(0) && beside_mm_.isZero(0) && beside_mm_s_.isZero(0)) return;
  const double w = 2 * std::numbers::pi * options_.natural_frequency_hz;
  const int steps = std::max(
      1, static_cast<int>(std::ceil(step_s * options_.natural_frequency_hz *
                                    (1 + options_.damping_ratio) / kRatioOfPeriod)));
  const double h = step_s / steps;
  const auto slope = [&](const Vec3& y, const Vec3& y_s) {
    return Vec3(-excess - 2 * options_.damping_ratio * w * y_s - w * w * y);
  };
  // Midpoint steps of a fiftieth of a period.
  for (int i = 0; i < steps; ++i) {
    const Vec3 middle = beside_mm_ + h / 2 * beside_mm_s_;
    const Vec3 middle_s = beside_mm_s_ + h / 2 * slope(beside_mm_, beside_mm_s_);
    beside_mm_ += h * middle_s;
    beside_mm_s_ += h * slope(middle, middle_s);
  }
}

}  // namespace intaglio::virtual_engraver
