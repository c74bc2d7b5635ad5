#pragma once

// The projection of a point of the block, frame glass in mm, to a place in the picture.

#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/render/canvas.h"

namespace intaglio::render {

/// Where a point appears, and how far away it is.
struct Projected {
  Vec2 at_px = Vec2::Zero();
  double depth_mm = 0.0;  ///< Grows away from the viewer.
};

/// Parallel or central projection. The axes are unit vectors of the glass frame,
/// perpendicular to one another, `forward` pointing away from the viewer.
class Projection {
 public:
  /// Parallel; `center_mm` appears at `center_px`.
  static Projection Parallel(const Vec3& right, const Vec3& up, const Vec3& center_mm,
                             const Vec2& center_px, double px_per_mm);

  /// Central, seen from a turn of `azimuth_rad` to the right of the front (-y) side and
  /// `elevation_rad` above the middle, from 3 diagonals away so that the lines still
  /// converge but nothing is distorted; the box (not empty) fills `into`. A roll turns
  /// the picture counterclockwise about the line of sight.
  static Projection Perspective(const Box3& box_mm, double azimuth_rad,
                                double elevation_rad, const Rect& into,
                                double roll_rad = 0);

  /// Parallel, from the same directions; the box fills `into`.
  static Projection ParallelView(const Box3& box_mm, double azimuth_rad,
                                 double elevation_rad, const Rect& into,
                                 double roll_rad = 0);

  Projected operator()(const Vec3& p_mm) const {
    const Vec3 from_origin = p_mm - origin_mm_;
    const double depth_mm = forward_.dot(from_origin);
    const double scale = central_ ? scale_ / depth_mm : scale_;
    return {Vec2(place_px_.x() + scale * right_.dot(from_origin),
                 place_px_.y() - scale * up_.dot(from_origin)),
            depth_mm};
  }

  const Vec3& forward() const { return forward_; }
  /// The unit vector in the picture (y down) of a direction in the middle of the view;
  /// zero for one along the line of sight.
  Vec2 PictureDirection(const Vec3& direction) const {
    return Vec2(right_.dot(direction), -up_.dot(direction)).normalized();
  }
  /// Pixels that a millimetre takes at the given depth.
  double px_per_mm(double depth_mm) const {
    return central_ ? scale_ / depth_mm : scale_;
  }
  /// Whether a face of the block with this outward normal at this place is seen.
  bool Sees(const Vec3& normal, const Vec3& place_mm) const;

 private:
  /// Turns the picture counterclockwise.
  void Roll(double roll_rad);
  /// With a scale of 1 about the origin: scaled and moved so that the box fills `into`.
  void FitInto(const Box3& box_mm, const Rect& into);

  Vec3 right_, up_, forward_;
  Vec3 origin_mm_;  ///< Parallel: what appears at place_px_. Central: the eye.
  Vec2 place_px_;
  double scale_ = 1.0;  ///< Parallel: px per mm. Central: focal length in px.
  bool central_ = false;
};

/// The eight corners; bit k of the index selects the high side of axis k.
std::vector<Vec3> CornersOf(const Box3& box_mm);

/// A step of 1, 2 or 5 times a power of ten that divides `range` into at most `most`.
double NiceStep(double range, int largest);

}  // namespace intaglio::render
