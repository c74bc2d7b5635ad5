#pragma once

// The shortest time along a parabola with bounded forces: the problem that Trochimczuk
// 2008 ch. 6.2.5 states with (69) and leaves to Pontryagin's maximum principle.
//
// Along the parabola x3 = h - k (x5 - b)^2 the plant (38) has one coordinate left, x5,
// whose acceleration is bounded by both forces,
//   u6 = (x5'' - alpha2 x6) / beta2,
//   u4 = (x3'' - alpha1 x4) / beta1,  x4 = m x6, x3'' = m x5'' - 2 k x6^2,
//   m = -2 k (x5 - b),
// which are linear in x5''. The Hamiltonian is linear in it, too, so that the maximum
// principle makes it the largest or the smallest that the forces allow, except where the
// largest speed is reached: in the plane of x5 and x6 the fastest motion is the lower
// envelope of the fastest from the start, the fastest into the end, and that speed
// (Bobrow, Dubowsky and Gibson 1985). It is integrated on a grid of x5.

#include <vector>

#include "engrave/core/result.h"

namespace intaglio::motion {

/// (38): x' = v, v' = alpha v + beta u, of both axes; alpha <= 0, beta > 0.
struct ForcedAxis {
  double alpha_per_s = 0;
  double beta_mm_s2_n = 1;
  double max_force_n = 1;  ///< > 0, in both directions
};

struct FastestMotion {
  double seconds = 0;
  std::vector<double> x5_mm;     ///< places, from 0 to 2 b
  std::vector<double> x6_mm_s;   ///< speed at each
  std::vector<double> x5_mm_s2;  ///< acceleration from each to the next
};

/// From rest at (0, 0) to rest at (2 b, 0). half_width_mm: b > 0; height_mm: h >= 0;
/// steps: of the grid, 100..1000000; the time is exact but for about 1 / steps^1.5 of it.
/// kUnsupported where the forces hold no speed at all.
Result<FastestMotion> FastestAlongParabola(double half_width_mm, double height_mm,
                                           const ForcedAxis& lift,
                                           const ForcedAxis& along, int steps = 4000);

}  // namespace intaglio::motion
