#include "services/drivers/linuxcnc/row_jog.h"

#include <algorithm>
#include <cmath>

namespace intaglio::drivers {

void RowJog::Begin(const Vec3& from_mm, const Vec3& to_mm, double speed_mm_s,
                   const Vec3& max_speed_mm_s, const Vec3& max_acceleration_mm_s2) {
  from_mm_ = from_mm;
  to_mm_ = to_mm;
  length_mm_ = (to_mm - from_mm).norm();
  speed_mm_s_ = speed_mm_s;
  acceleration_mm_s2_ = max_acceleration_mm_s2.maxCoeff();
  elapsed_s_ = 0;
  active_ = true;
  for (int i = 0; length_mm_ > 0 && i < 3; ++i) {
    const double share = std::abs(to_mm[i] - from_mm[i]) / length_mm_;
    if (share == 0) continue;
    speed_mm_s_ = std::min(speed_mm_s_, max_speed_mm_s[i] / share);
    acceleration_mm_s2_ =
        std::min(acceleration_mm_s2_, max_acceleration_mm_s2[i] / share);
  }
  // A short way does not reach its speed.
  speed_mm_s_ = std::min(speed_mm_s_, std::sqrt(length_mm_ * acceleration_mm_s2_));
}

Vec3 RowJog::Next(double period_s) {
  elapsed_s_ += period_s;
  const double ramp_s = speed_mm_s_ / acceleration_mm_s2_;
  const double total_s = speed_mm_s_ > 0 ? length_mm_ / speed_mm_s_ + ramp_s : 0;
  if (elapsed_s_ >= total_s) {
    active_ = false;
    return to_mm_;
  }
  const double left_s = total_s - elapsed_s_;
  double way_mm = speed_mm_s_ * (elapsed_s_ - 0.5 * ramp_s);
  if (elapsed_s_ < ramp_s)
    way_mm = 0.5 * acceleration_mm_s2_ * elapsed_s_ * elapsed_s_;
  else if (left_s < ramp_s)
    way_mm = length_mm_ - 0.5 * acceleration_mm_s2_ * left_s * left_s;
  return from_mm_ + (to_mm_ - from_mm_) * (way_mm / length_mm_);
}

}  // namespace intaglio::drivers
