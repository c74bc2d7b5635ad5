#pragma once

// What a machine's frame adds to the place of what its axes carry when they accelerate
// too much: the acceleration beyond a limit, axis by axis, sets off an oscillation
//   y'' + 2 d w y' + w^2 y = -(a - limited(a)),   w = 2 pi natural_frequency_hz.
// No encoder measures it.

#include "engrave/core/geometry.h"

namespace intaglio::virtual_engraver {

struct VibrationOptions {
  double above_mm_s2 = 7500;          ///< >= 0
  double natural_frequency_hz = 100;  ///< > 0
  double damping_ratio = 0.1;         ///< > 0
};

class Vibration {
 public:
  /// At rest, with the axes at rest at `at_mm`.
  Vibration(const VibrationOptions& options, const Vec3& at_mm)
      : options_(options), last_mm_(at_mm) {}

  /// The axes have gone to `actual_mm` in `step_s` > 0.
  void Follow(const Vec3& actual_mm, double step_s);
  /// What it adds, mm.
  const Vec3& beside_mm() const { return beside_mm_; }

 private:
  VibrationOptions options_;
  Vec3 last_mm_;
  Vec3 last_mm_s_ = Vec3::Zero();
  double last_step_s_ = 0;
  Vec3 beside_mm_ = Vec3::Zero(), beside_mm_s_ = Vec3::Zero();
};

}  // namespace intaglio::virtual_engraver
