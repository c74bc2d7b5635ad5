#pragma once

// What axes with a lag make of setpoints, integrated here in small steps: a judge of the
// planner's own model.

#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::linuxcnc {

/// x'' = w^2 (c - x) - 2 xi w x', with c straight between setpoints; from rest.
inline std::vector<Vec2> Driven(const std::vector<Vec2>& setpoints_mm,
                                double natural_rad_s, double damping, double period_s) {
  constexpr int kSteps = 200;
  const double h_s = period_s / kSteps;
  std::vector<Vec2> driven_mm = {setpoints_mm.front()};
  Vec2 x = setpoints_mm.front(), v = Vec2::Zero();
  for (std::size_t i = 1; i < setpoints_mm.size(); ++i) {
    for (int k = 0; k < kSteps; ++k) {
      const double share = (k + 0.5) / kSteps;
      const Vec2 c =
          setpoints_mm[i - 1] + (setpoints_mm[i] - setpoints_mm[i - 1]) * share;
      const Vec2 a =
          natural_rad_s * natural_rad_s * (c - x) - 2 * damping * natural_rad_s * v;
      v += a * h_s;
      x += v * h_s;
    }
    driven_mm.push_back(x);
  }
  return driven_mm;
}

}  // namespace intaglio::linuxcnc
