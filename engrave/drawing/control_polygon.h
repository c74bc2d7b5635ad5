#pragma once

// The control points of a part of a curve. By them it is known, and not guessed from
// single points, that a part follows its chord: a Bezier curve with positive weights lies
// within the hull of its control points, and crosses no plane more often than their
// polygon does (Farin 2002, ch. 5 and 13).
//
// Frame: that of the drawing, mm.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <utility>

#include "engrave/drawing/drawing.h"

namespace intaglio::drawing {

class ControlPolygon {
 public:
  explicit ControlPolygon(const CubicBezier& bezier);
  /// From knots[span] to knots[span + 1], which is greater; degree 1 .. kMaxSplineDegree.
  ControlPolygon(const Nurbs& nurbs, std::size_t span);
  /// Copies the points that there are: a letter's four, of sixteen that have room.
  ControlPolygon(const ControlPolygon& other);
  ControlPolygon& operator=(const ControlPolygon& other);

  /// At a share of the parameter, 0 .. 1.
  std::pair<ControlPolygon, ControlPolygon> SplitAt(double share) const;

  /// The curve goes from its first point to its last without turning back, and is nowhere
  /// farther than the tolerance from the line between both.
  bool FollowsChord(double tolerance_mm) const;
  /// No point of the curve is farther than this from its first one.
  bool IsWithin(double distance_mm) const;

 private:
  explicit ControlPolygon(std::size_t degree) : degree_(degree) {}
  Vec3 Place(std::size_t i) const { return points_[i].head<3>() / points_[i].w(); }
  /// What a control point's distance from the chord counts for the curve at most.
  double Share() const;

  std::size_t degree_ = 0;
  /// Homogeneous; the first degree_ + 1.
  std::array<Eigen::Vector4d, kMaxSplineDegree + 1> points_;
};

/// A part of an ellipse of less than a half turn, from one value of t to another.
class ArcPart {
 public:
  ArcPart(const EllipticArc& arc, double begin, double end)
      : arc_(&arc), begin_(begin), end_(end) {}
  std::pair<ArcPart, ArcPart> SplitAt(double share) const;
  /// As above. Its distance is greatest in the middle, in every projection of a circle.
  bool FollowsChord(double tolerance_mm) const;
  /// Chords of an arc that is shorter than an eighth turn are hardly shorter than it.
  bool IsWithin(double) const { return true; }

 private:
  const EllipticArc* arc_;
  double begin_, end_;
};

}  // namespace intaglio::drawing
