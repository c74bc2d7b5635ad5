#pragma once

// A straight line or an arc of a circle: what contours are made of, exactly as a
// controller makes them. Frame: drawing, mm, x to the right, y up.

#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::contour {

/// From begin_mm to end_mm. An arc about center_mm begins at the angle begin_rad and runs
/// over sweep_rad, counter-clockwise when that is positive, |sweep_rad| <= 2 pi. Made by
/// MakeLine and MakeArc, which keep the fields consistent.
struct Edge {
  Vec2 begin_mm = Vec2::Zero();
  Vec2 end_mm = Vec2::Zero();
  Vec2 center_mm = Vec2::Zero();  ///< of an arc
  double radius_mm = 0;           ///< 0: a line
  double begin_rad = 0;
  double sweep_rad = 0;
  double length_mm = 0;

  bool is_arc() const { return radius_mm > 0; }
};

using Edges = std::vector<Edge>;

Edge MakeLine(const Vec2& begin_mm, const Vec2& end_mm);

/// radius_mm > 0.
Edge MakeArc(const Vec2& center_mm, double radius_mm, double begin_rad, double sweep_rad);

/// From point to point about a center that both are equally far from; where they are
/// not, the radius is the mean. Equal points: a full circle.
Edge MakeArcBetween(const Vec2& begin_mm, const Vec2& end_mm, const Vec2& center_mm,
                    bool counter_clockwise);

/// s_mm: way from the beginning, 0 .. length_mm.
Vec2 PointAt(const Edge& edge, double s_mm);

/// Of length 1. An edge has to be longer than 0.
Vec2 DirectionAt(const Edge& edge, double s_mm);

/// To the right of the direction: out of an area that lies to the left.
inline Vec2 RightOf(const Vec2& direction) { return {direction.y(), -direction.x()}; }

/// The part from s_mm to t_mm; its ends are the points given.
Edge PartOf(const Edge& edge, double s_mm, double t_mm, const Vec2& begin_mm,
            const Vec2& end_mm);

Edge Reversed(const Edge& edge);

/// The way from the beginning to the point of the edge nearest to `point_mm` in
/// direction (arc) or along the line: below 0 or above length_mm when it is not between
/// the ends.
double WayTo(const Edge& edge, const Vec2& point_mm);

/// To the nearest point of the edge.
double DistanceTo(const Edge& edge, const Vec2& point_mm);

/// Twice the area that the edge sweeps about the origin (Green's theorem): their sum over
/// a closed contour is twice its area, positive when it runs counter-clockwise.
double TwiceSweptArea(const Edge& edge);

/// Positive counter-clockwise.
double AreaOf(const Edges& closed_mm);
double LengthOf(const Edges& edges_mm);

inline double Cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace intaglio::contour
