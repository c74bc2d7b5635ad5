#include "engrave/contour/edge.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/core/geometry.h"

namespace intaglio::contour {
namespace {

/// The angle in [0, 2 pi).
double PositiveAngle(double angle_rad) {
  const double turned = angle_rad - kTwoPi * std::floor(angle_rad / kTwoPi);
  return turned < kTwoPi ? turned : 0;
}

}  // namespace

Edge MakeLine(const Vec2& begin_mm, const Vec2& end_mm) {
  Edge line;
  line.begin_mm = begin_mm;
  line.end_mm = end_mm;
  line.length_mm = (end_mm - begin_mm).norm();
  return line;
}

Edge MakeArc(const Vec2& center_mm, double radius_mm, double begin_rad,
             double sweep_rad) {
  Require(radius_mm > 0, "the radius of an arc must be positive, is {}", radius_mm);
  Edge arc;
  arc.center_mm = center_mm;
  arc.radius_mm = radius_mm;
  arc.begin_rad = begin_rad;
  arc.sweep_rad = sweep_rad;
  arc.length_mm = radius_mm * std::abs(sweep_rad);
  arc.begin_mm = PointAt(arc, 0);
  // The ends of a full circle are one place, to the last bit.
  const bool full = std::abs(sweep_rad) >= kTwoPi;
  arc.end_mm = full ? arc.begin_mm : PointAt(arc, arc.length_mm);
  return arc;
}

Edge MakeArcBetween(const Vec2& begin_mm, const Vec2& end_mm, const Vec2& center_mm,
                    bool counter_clockwise) {
  const Vec2 from = begin_mm - center_mm;
  const Vec2 to = end_mm - center_mm;
  const double begin_rad = std::atan2(from.y(), from.x());
  const double turn = std::atan2(Cross(from, to), from.dot(to));
  double sweep_rad = counter_clockwise ? PositiveAngle(turn) : -PositiveAngle(-turn);
  if (begin_mm == end_mm) sweep_rad = counter_clockwise ? kTwoPi : -kTwoPi;
  Edge arc = MakeArc(center_mm, 0.5 * (from.norm() + to.norm()), begin_rad, sweep_rad);
  arc.begin_mm = begin_mm;
  arc.end_mm = end_mm;
  return arc;
}

Vec2 PointAt(const Edge& edge, double s_mm) {
  if (!edge.is_arc()) {
    if (edge.length_mm == 0) return edge.begin_mm;
    return edge.begin_mm + (s_mm / edge.length_mm) * (edge.end_mm - edge.begin_mm);
  }
  const double angle =
      edge.begin_rad + std::copysign(s_mm / edge.radius_mm, edge.sweep_rad);
  return edge.center_mm + edge.radius_mm * Vec2(std::cos(angle), std::sin(angle));
}

Vec2 DirectionAt(const Edge& edge, double s_mm) {
  if (!edge.is_arc()) return (edge.end_mm - edge.begin_mm) / edge.length_mm;
  const double side = edge.sweep_rad < 0 ? -1 : 1;
  const double angle = edge.begin_rad + side * s_mm / edge.radius_mm;
  return side * Vec2(-std::sin(angle), std::cos(angle));
}

Edge PartOf(const Edge& edge, double s_mm, double t_mm, const Vec2& begin_mm,
            const Vec2& end_mm) {
  Edge part = edge;
  part.begin_mm = begin_mm;
  part.end_mm = end_mm;
  part.length_mm = t_mm - s_mm;
  if (edge.is_arc()) {
    const double side = edge.sweep_rad < 0 ? -1 : 1;
    part.begin_rad += side * s_mm / edge.radius_mm;
    part.sweep_rad = side * part.length_mm / edge.radius_mm;
  } else {
    part.length_mm = (end_mm - begin_mm).norm();
  }
  return part;
}

Edge Reversed(const Edge& edge) {
  Edge reversed = edge;
  std::swap(reversed.begin_mm, reversed.end_mm);
  reversed.begin_rad = edge.begin_rad + edge.sweep_rad;
  reversed.sweep_rad = -edge.sweep_rad;
  return reversed;
}

double WayTo(const Edge& edge, const Vec2& point_mm) {
  if (!edge.is_arc()) {
    if (edge.length_mm == 0) return 0;
    return (point_mm - edge.begin_mm).dot(edge.end_mm - edge.begin_mm) / edge.length_mm;
  }
  const Vec2 from_center = point_mm - edge.center_mm;
  const double angle = std::atan2(from_center.y(), from_center.x());
  const double side = edge.sweep_rad < 0 ? -1 : 1;
  double turned = PositiveAngle(side * (angle - edge.begin_rad));
  // What is not on the arc lies before its beginning when that is nearer than its end.
  const double sweep = std::abs(edge.sweep_rad);
  if (turned > sweep && kTwoPi - turned < turned - sweep) turned -= kTwoPi;
  return turned * edge.radius_mm;
}

double DistanceTo(const Edge& edge, const Vec2& point_mm) {
  const double way = WayTo(edge, point_mm);
  if (way < 0 || way > edge.length_mm) {
    return std::min((point_mm - edge.begin_mm).norm(), (point_mm - edge.end_mm).norm());
  }
  if (edge.is_arc()) return std::abs((point_mm - edge.center_mm).norm() - edge.radius_mm);
  if (edge.length_mm == 0) return (point_mm - edge.begin_mm).norm();
  return std::abs(Cross(edge.end_mm - edge.begin_mm, point_mm - edge.begin_mm)) /
         edge.length_mm;
}

double TwiceSweptArea(const Edge& edge) {
  const double chord = Cross(edge.begin_mm, edge.end_mm);
  if (!edge.is_arc()) return chord;
  // The triangle about the origin, and the segment between chord and arc.
  const double r2 = edge.radius_mm * edge.radius_mm;
  return chord + r2 * (edge.sweep_rad - std::sin(edge.sweep_rad));
}

double AreaOf(const Edges& closed_mm) {
  double twice = 0;
  for (const Edge& edge : closed_mm) twice += TwiceSweptArea(edge);
  return twice / 2;
}

double LengthOf(const Edges& edges_mm) {
  double length = 0;
  for (const Edge& edge : edges_mm) length += edge.length_mm;
  return length;
}

}  // namespace intaglio::contour
