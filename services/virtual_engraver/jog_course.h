#pragma once

// A move by hand: straight from rest to rest, with constant acceleration up to a speed.
// In lengths of the focus, mm; times in s.

#include "services/virtual_engraver/mechanics/mechanics.h"

namespace intaglio::virtual_engraver {

class JogCourse {
 public:
  /// From `from` straight to `to`, axes' units, `length_mm` > 0 long at the focus, with
  /// at most `speed_mm_s` > 0 and `acceleration_mm_s2` > 0.
  JogCourse(const Vec3& from, const Vec3& to, double length_mm, double speed_mm_s,
            double acceleration_mm_s2);

  /// It brakes from now on, wherever it gets.
  void Brake() { braking_ = true; }

  /// A stretch of constant acceleration of at most `left_s` > 0.
  struct Stretch {
    CubicCommand curve;
    double seconds = 0;
  };
  /// Not when done().
  Stretch Next(double left_s);
  bool done() const { return done_; }

 private:
  Vec3 from_, per_mm_;
  double length_mm_, speed_mm_s_, acceleration_mm_s2_;
  double at_mm_ = 0, now_mm_s_ = 0;
  bool braking_ = false, done_ = false;
};

}  // namespace intaglio::virtual_engraver
