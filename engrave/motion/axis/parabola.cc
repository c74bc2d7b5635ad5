#include "engrave/motion/axis/parabola.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

// The arc from the apex to y = x5 - b is, by (47),
//   f(y) = (1 / 4k) [w sqrt(1 + w^2) + ln(w + sqrt(1 + w^2))],   w = 2 k y
//        = (y / 2) [sqrt(1 + w^2) + asinh(w) / w],
// which has no division by k: the flat parabola is no special case. f' = sqrt(1 + w^2).
// f is odd, and convex for y > 0, so Newton's steps from the chord, which lies above it
// there, come down to the root after the first one and never leave 0..b.

namespace intaglio::motion {
namespace {

/// asinh(w) / w; below 1e-4 its series, exact to w^4.
double AsinhRatio(double w) {
  return std::abs(w) < 1e-4 ? 1.0 - w * w / 6.0 : std::asinh(w) / w;
}

}  // namespace

Parabola::Parabola(double half_width_mm, double height_mm)
    : b_mm_(half_width_mm), k_per_mm_(height_mm / (half_width_mm * half_width_mm)) {
  Require(half_width_mm > 0.0 && height_mm >= 0.0 && std::isfinite(k_per_mm_),
          "a parabola of half width {} mm and height {} mm", half_width_mm, height_mm);
  length_mm_ = 2.0 * HalfLength(b_mm_);
}

double Parabola::X3(double x5_mm) const {
  // h - k (x5 - b)^2 with h = k b^2, without the difference near the ends.
  return k_per_mm_ * x5_mm * (2.0 * b_mm_ - x5_mm);
}

double Parabola::Slope(double x5_mm) const { return -2.0 * k_per_mm_ * (x5_mm - b_mm_); }

double Parabola::HalfLength(double from_apex_mm) const {
  const double w = 2.0 * k_per_mm_ * from_apex_mm;
  return 0.5 * from_apex_mm * (std::sqrt(1.0 + w * w) + AsinhRatio(w));
}

double Parabola::X5AtLength(double along_mm) const {
  const double half_mm = 0.5 * length_mm_;
  const double wanted_mm = std::clamp(along_mm - half_mm, -half_mm, half_mm);
  double y_mm = wanted_mm / half_mm * b_mm_;
  for (int i = 0; i < 50; ++i) {
    const double w = 2.0 * k_per_mm_ * y_mm;
    const double step_mm = (wanted_mm - HalfLength(y_mm)) / std::sqrt(1.0 + w * w);
    y_mm += step_mm;
    if (std::abs(step_mm) <= 1e-15 * b_mm_) break;
  }
  return b_mm_ + std::clamp(y_mm, -b_mm_, b_mm_);
}

ParabolaState Parabola::At(double along_mm, double speed_mm_s) const {
  const double x5_mm = X5AtLength(along_mm);
  const double m = Slope(x5_mm);
  const double x6_mm_s = speed_mm_s / std::sqrt(1.0 + m * m);
  return {X3(x5_mm), m * x6_mm_s, x5_mm, x6_mm_s};
}

}  // namespace intaglio::motion
