#pragma once

// Play between what an axis drives and what it carries: the carriage rests while the
// drive crosses the play, and then is taken along, half the play behind it. Each axis by
// itself; the encoder is on the drive's side and does not see it.

#include "engrave/core/geometry.h"

namespace intaglio::virtual_engraver {

class Backlash {
 public:
  /// >= 0 on each axis; 0: none. At first the drive is in the middle of the play.
  Backlash(const Vec3& play_mm, const Vec3& at_mm)
      : half_mm_(0.5 * play_mm), carried_mm_(at_mm) {}

  bool none() const { return half_mm_.isZero(0); }
  /// The drive has gone to here, without turning on the way.
  void Follow(const Vec3& drive_mm) {
    carried_mm_ = carried_mm_.cwiseMax(drive_mm - half_mm_).cwiseMin(drive_mm + half_mm_);
  }
  /// Where what is carried is.
  const Vec3& carried_mm() const { return carried_mm_; }

 private:
  Vec3 half_mm_, carried_mm_;
};

}  // namespace intaglio::virtual_engraver
