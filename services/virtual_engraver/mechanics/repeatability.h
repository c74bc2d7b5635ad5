#pragma once

// How far the places that the stage goes to lie from where it reports to be: backlash,
// friction, what no encoder sees. For every end of a segment a deviation is drawn, on
// each axis uniform in -repeatability .. repeatability; between two ends it goes over
// smoothly. The same seed and the same segments give the same deviations.

#include <random>

#include "engrave/core/geometry.h"

namespace intaglio::virtual_engraver {

class Repeatability {
 public:
  /// >= 0; 0: none.
  Repeatability(double repeatability_mm, unsigned seed);

  /// The segment under way ends, another begins.
  void PassEnd();
  /// Another segment begins where the one under way is done to this ratio, 0..1.
  void LeaveAt(double done_ratio) { from_mm_ = DeviationMm(done_ratio); }
  /// With the segment under way done to this ratio, 0..1.
  Vec3 DeviationMm(double done_ratio) const;

 private:
  Vec3 Draw();

  double repeatability_mm_;
  std::mt19937_64 random_;
  Vec3 from_mm_ = Vec3::Zero(), to_mm_ = Vec3::Zero();
};

}  // namespace intaglio::virtual_engraver
