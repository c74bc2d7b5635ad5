#pragma once

// A scan head of the tests' own: a ray reflected at two mirrors that turn, then a lens.
// It shares no code with engrave/galvo and has none of its formulas.

#include <array>

#include "engrave/core/geometry.h"

namespace intaglio::galvo {

/// Direction behind both mirrors of a beam along z at zero; the first mirror turns about
/// an axis across the beam and deflects y, the second deflects x. Optical angles, rad.
Vec3 TracedDirection(double ax_rad, double ay_rad);

/// Place behind a lens whose image heights are h[0] t + h[1] t^2 + ..., mm.
Vec2 TracedThroughLens(double ax_rad, double ay_rad, const std::array<double, 4>& h_mm);

/// Place without a lens: the first mirror deflects x, the second, `gap_mm` behind it, y;
/// the field is `distance_mm` below the second.
Vec2 TracedWithoutLens(double ax_rad, double ay_rad, double distance_mm, double gap_mm);

/// A field that is wrong by a share of its width: the control turns the mirrors by
/// command / focal length, the lens has a cubic term, the first mirror is 2' off, and the
/// frame of the camera is 50 um off.
class WrongField {
 public:
  /// `share`: the greatest deviation by the width. `half_angle_deg`: optical, at the
  /// border. Throws when no cubic term gives it.
  WrongField(double width_mm, double share, double half_angle_deg);

  /// Where a command arrives, mm.
  Vec2 Arrive(const Vec2& command_mm) const;
  /// The command that arrives there, by iteration to 1e-12 mm.
  Vec2 Inverse(const Vec2& place_mm) const;

  double width_mm() const { return width_mm_; }
  double focal_mm() const { return focal_mm_; }

 private:
  Vec2 Raw(const Vec2& command_mm, double cubic) const;
  double Worst(double cubic) const;

  double width_mm_, focal_mm_, cubic_ = 0;
  Vec2 centre_mm_ = Vec2::Zero();
};

}  // namespace intaglio::galvo
