#pragma once

// The glass above a point that must hold no crack when the point is fired.
//
// The beam converges from above (+z): a pulse for the point p fills the upward cone with
// its apex at p and the half angle of the beam in the glass (optics/focus.h,
// ConeTangentInGlass). A crack in it scatters the pulse (Trochimczuk 2008 ch. 1 and 6.7).
// A crack is not a point: it reaches into the cone from up to its radius beside it. Close
// above p, within a crack's length, both cracks overlap in height and the beam between
// them is narrow; there its radius counts in proportion to the height. Below a scan head
// the axis of the cone leans (beam_lean.h): heights are still along z, and what lies
// across is measured from the leaning axis.

#include <algorithm>
#include <cmath>
#include <optional>

#include "engrave/core/geometry.h"
#include "engrave/sort/beam/beam_lean.h"

namespace intaglio::sort {

/// Frame glass. Where cracks are taken as points, the tangent alone describes the cone.
struct BeamCone {
  BeamCone(double tangent_of_cone = 0, double radius_mm = 0, double length_mm = 1)
      : tangent(tangent_of_cone),
        crack_radius_mm(radius_mm),
        crack_length_mm(length_mm) {}

  double tangent;                     ///< of the half angle in the glass, >= 0
  double crack_radius_mm;             ///< >= 0; 0: cracks are taken as points
  double crack_length_mm;             ///< > 0, along z
  std::optional<BeamLean> lean = {};  ///< none: the axis is upright

  /// How far the shaded region reaches from the axis, `up_mm` > 0 above the apex.
  double ReachMm(double up_mm) const {
    return tangent * up_mm + crack_radius_mm * std::min(1.0, up_mm / crack_length_mm);
  }

  /// Whether a crack `across_mm` >= 0 beside and `up_mm` above a point shades it. Inside
  /// means by more than 1e-9 mm: nearer to the surface, rounding would decide.
  bool Shades(double across_mm, double up_mm) const {
    return up_mm > 0 && across_mm + kSurfaceMm < ReachMm(up_mm);
  }

  /// How far the axis of a point's cone moves across for each mm up.
  Vec2 LeanAt(const Vec3& apex_mm) const {
    return lean ? lean->UpwardAt(apex_mm) : Vec2(0, 0);
  }
  /// Whether a crack at `above_mm` is in the cone of the apex.
  bool Shades(const Vec3& apex_mm, const Vec3& above_mm) const {
    const Vec3 up_mm = above_mm - apex_mm;
    return up_mm.z() > 0 && Shades(up_mm, LeanAt(apex_mm));
  }
  /// The same by the way from the apex, whose cone leans by `lean_ratio`.
  bool Shades(const Vec3& up_mm, const Vec2& lean_ratio) const {
    const double x = up_mm.x() - lean_ratio.x() * up_mm.z();
    const double y = up_mm.y() - lean_ratio.y() * up_mm.z();
    return Shades(std::sqrt(x * x + y * y), up_mm.z());
  }

  double SteepestLean() const { return lean ? lean->Steepest() : 0; }
  /// The steepest reach: no shading crack is farther across than this times its height.
  double SteepestTangent() const {
    return tangent + crack_radius_mm / crack_length_mm + SteepestLean();
  }

  static constexpr double kSurfaceMm = 1e-9;
};

/// Throws PreconditionError unless all of it is in its ranges.
void RequireUsable(const BeamCone& cone);

}  // namespace intaglio::sort
