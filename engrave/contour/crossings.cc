#include "engrave/contour/crossings.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/geometry.h"

namespace intaglio::contour {
namespace {

// Lines and circles that miss each other by less are taken to touch, mm.
constexpr double kTouch_mm = 1e-9;

void AddIfReached(const Edge& a, const Edge& b, const Vec2& point,
                  std::vector<Vec2>& points) {
  for (const Edge* edge : {&a, &b}) {
    const double way = WayTo(*edge, point);
    if (way < -kVertex_mm || way > edge->length_mm + kVertex_mm) return;
  }
  points.push_back(point);
}

void AddLineLine(const Edge& a, const Edge& b, std::vector<Vec2>& points) {
  const Vec2 along_a = a.end_mm - a.begin_mm;
  const Vec2 along_b = b.end_mm - b.begin_mm;
  const double turn = Cross(along_a, along_b);
  if (std::abs(turn) <= 1e-13 * a.length_mm * b.length_mm) return;
  const double t = Cross(b.begin_mm - a.begin_mm, along_b) / turn;
  AddIfReached(a, b, a.begin_mm + t * along_a, points);
}

void AddLineArc(const Edge& line, const Edge& arc, std::vector<Vec2>& points) {
  const Vec2 along = (line.end_mm - line.begin_mm) / line.length_mm;
  const Vec2 to_center = arc.center_mm - line.begin_mm;
  const double off = std::abs(Cross(along, to_center));
  const double half2 = (arc.radius_mm - off) * (arc.radius_mm + off);
  if (half2 < -2 * arc.radius_mm * kTouch_mm) return;
  const double half = std::sqrt(std::max(half2, 0.0));
  const double middle = to_center.dot(along);
  AddIfReached(line, arc, line.begin_mm + (middle - half) * along, points);
  if (half > 0) AddIfReached(line, arc, line.begin_mm + (middle + half) * along, points);
}

void AddArcArc(const Edge& a, const Edge& b, std::vector<Vec2>& points) {
  const Vec2 between = b.center_mm - a.center_mm;
  const double distance = between.norm();
  if (distance < kTouch_mm || distance > a.radius_mm + b.radius_mm + kTouch_mm ||
      distance < std::abs(a.radius_mm - b.radius_mm) - kTouch_mm)
    return;
  const double middle =
      (distance * distance + (a.radius_mm - b.radius_mm) * (a.radius_mm + b.radius_mm)) /
      (2 * distance);
  const double half =
      std::sqrt(std::max((a.radius_mm - middle) * (a.radius_mm + middle), 0.0));
  const Vec2 along = between / distance;
  const Vec2 foot = a.center_mm + middle * along;
  AddIfReached(a, b, foot + half * RightOf(along), points);
  if (half > 0) AddIfReached(a, b, foot - half * RightOf(along), points);
}

void AddSharedLines(const Edge& a, const Edge& b, double tolerance,
                    std::vector<SharedPart>& parts) {
  const Vec2 along = (a.end_mm - a.begin_mm) / a.length_mm;
  const double from = (b.begin_mm - a.begin_mm).dot(along);
  const double to = (b.end_mm - a.begin_mm).dot(along);
  const double begin = std::max(std::min(from, to), 0.0);
  const double end = std::min(std::max(from, to), a.length_mm);
  if (end - begin <= kVertex_mm) return;
  // How far b is from a where the part begins and ends: linear between b's ends.
  const double off_from = Cross(along, b.begin_mm - a.begin_mm);
  const double slope = (Cross(along, b.end_mm - a.begin_mm) - off_from) / (to - from);
  for (const double s : {begin, end}) {
    if (std::abs(off_from + slope * (s - from)) > tolerance) return;
  }
  parts.push_back({begin, end, to > from});
}

void AddSharedArcs(const Edge& a, const Edge& b, double tolerance,
                   std::vector<SharedPart>& parts) {
  if ((a.center_mm - b.center_mm).norm() > tolerance ||
      std::abs(a.radius_mm - b.radius_mm) > tolerance)
    return;
  const bool same = (a.sweep_rad > 0) == (b.sweep_rad > 0);
  const double side = a.sweep_rad < 0 ? -1 : 1;
  const double b_begin = same ? b.begin_rad : b.begin_rad + b.sweep_rad;
  double from = side * (b_begin - a.begin_rad);
  from -= kTwoPi * std::floor(from / kTwoPi);
  const double sweep_a = std::abs(a.sweep_rad);
  const double sweep_b = std::abs(b.sweep_rad);
  for (const double turned : {from - kTwoPi, from}) {
    const double begin = std::max(turned, 0.0) * a.radius_mm;
    const double end = std::min(turned + sweep_b, sweep_a) * a.radius_mm;
    if (end - begin > kVertex_mm) parts.push_back({begin, end, same});
  }
}

}  // namespace

void AppendCrossings(const Edge& a, const Edge& b, std::vector<Vec2>& points_mm) {
  if (a.is_arc() && b.is_arc()) return AddArcArc(a, b, points_mm);
  if (a.is_arc()) return AddLineArc(b, a, points_mm);
  if (b.is_arc()) return AddLineArc(a, b, points_mm);
  AddLineLine(a, b, points_mm);
}

void AppendSharedParts(const Edge& a, const Edge& b, double tolerance_mm,
                       std::vector<SharedPart>& parts) {
  if (a.is_arc() != b.is_arc()) return;
  if (a.is_arc()) return AddSharedArcs(a, b, tolerance_mm, parts);
  AddSharedLines(a, b, tolerance_mm, parts);
}

}  // namespace intaglio::contour
