#pragma once

// A measured circle as ISO 230-4 evaluates it, and what of two axes explains it.
//
// With r_k and t_k radius and angle of a point about the centre of smallest squares, and
// R the radius that was commanded:
//   circular deviation G   largest r_k minus smallest (two concentric circles around that
//                          centre)
//   radial deviation F     largest and smallest r_k - R, about the commanded centre where
//                          it is known, else about that of smallest squares
//   r_k = r0 + a cos 2 t + b sin 2 t + rest, by smallest squares: 2 a / R is the scale of
//   x beyond that of y; 2 b / R the squareness, rad, above 0 where the angle between the
//   axes is below a right angle. Lags of the axes add (F / R) (lag x - lag y) to it on a
//   circle that runs counterclockwise with the feed F, and subtract it on one that runs
//   clockwise: half the sum of both directions is the squareness, half the difference the
//   lags.
//
// Source: ISO 230-4:2005, Circular tests for numerically controlled machine tools, ch. 3
// (terms) and 6; the second harmonic is ours.

#include <optional>
#include <span>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::calibrate {

struct CircleCheck {
  Vec2 centre_mm = Vec2::Zero();  ///< of smallest squares
  double radius_mm = 0;           ///< mean of r_k
  double circular_deviation_mm = 0;
  double max_radial_mm = 0, min_radial_mm = 0;
  double scale_ratio = 0;     ///< 2 a / R
  double squareness_rad = 0;  ///< 2 b / R
  /// Largest minus smallest of the rest: what neither scale nor squareness explains.
  double rest_mm = 0;
  /// Largest angle between neighbouring points, rad.
  double gap_rad = 0;
};

/// `points_mm`: in any order. `centre_mm`: that was commanded, if the frame of the points
/// knows it. kMissing: fewer than 8 points. kInvalidValue: a coordinate that is no
/// number, points on a line, `radius_mm` not above 0, or a gap above 90 degrees: a part
/// of a circle is another check.
Result<CircleCheck> CheckCircle(std::span<const Vec2> points_mm, double radius_mm,
                                const std::optional<Vec2>& centre_mm);

}  // namespace intaglio::calibrate
