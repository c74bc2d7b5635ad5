#pragma once

// A straight way by hand, sampled at the servo periods: from rest to rest with constant
// acceleration, constant speed, and the same deceleration.

#include "engrave/core/geometry.h"

namespace intaglio::drivers {

class RowJog {
 public:
  /// Limits of each axis: mm/s and mm/s^2, > 0; `speed_mm_s`: of the way, > 0.
  void Begin(const Vec3& from_mm, const Vec3& to_mm, double speed_mm_s,
             const Vec3& max_speed_mm_s, const Vec3& max_acceleration_mm_s2);
  /// The place one period later; of the last one exactly the end, and then it is not
  /// active any more. Only while it is active.
  Vec3 Next(double period_s);
  void End() { active_ = false; }
  bool active() const { return active_; }

 private:
  bool active_ = false;
  Vec3 from_mm_ = Vec3::Zero(), to_mm_ = Vec3::Zero();
  double length_mm_ = 0, speed_mm_s_ = 0, acceleration_mm_s2_ = 0;
  double elapsed_s_ = 0;
};

}  // namespace intaglio::drivers
