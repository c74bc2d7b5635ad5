#include "services/virtual_engraver/mechanics/repeatability.h"

namespace intaglio::virtual_engraver {

Repeatability::Repeatability(double repeatability_mm, unsigned seed)
    : repeatability_mm_(repeatability_mm), random_(seed), to_mm_(Draw()) {}

Vec3 Repeatability::Draw() {
  if (repeatability_mm_ <= 0) return Vec3::Zero();
  Vec3 deviation_mm;
  for (double& axis_mm : deviation_mm) {
    // std::uniform_real_distribution may differ between libraries; this does not.
    const double ratio = static_cast<double>(random_() >> 11) * 0x1p-53;
    axis_mm = repeatability_mm_ * (2 * ratio - 1);
  }
  return deviation_mm;
}

void Repeatability::PassEnd() {
  from_mm_ = to_mm_;
  to_mm_ = Draw();
}

Vec3 Repeatability::DeviationMm(double done_ratio) const {
  const double share = done_ratio * done_ratio * (3 - 2 * done_ratio);
  return from_mm_ + share * (to_mm_ - from_mm_);
}

}  // namespace intaglio::virtual_engraver
