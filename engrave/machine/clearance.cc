// A body of radius R meets the box of a solid where the focus p is nearer than R to the
// box's rectangle, seen from above, and p.z + bottom is below the box's top. The places
// within R of a rectangle are the union of the rectangle grown by R along x, the one
// grown by R along y, and the discs of radius R around its corners: a convex set, so the
// straight way p(t) = from + t (to - from) is within it for one interval of t, the hull
// of the intervals within its parts. The overlap, top - bottom - p(t).z, is linear in t
// and greatest at an end of that interval.

#include "engrave/machine/clearance.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

namespace intaglio::machine {
namespace {

// Nothing is placed so exactly; it is above the rounding of a few thousand mm.
constexpr double kTouchMm = 1e-6;

/// An interval of t; empty: from > to.
struct Interval {
  double from = 0, to = 1;

  bool empty() const { return from > to; }
};

/// Where from + t way is within low..high.
Interval WithinBand(double from, double way, double low, double high, Interval within) {
  if (way == 0) return from >= low && from <= high ? within : Interval{1, 0};
  const double enters = (low - from) / way, leaves = (high - from) / way;
  return {std::max(within.from, std::min(enters, leaves)),
          std::min(within.to, std::max(enters, leaves))};
}

Interval WithinRectangle(const Vec2& from, const Vec2& way, const Vec2& low,
                         const Vec2& high) {
  const Interval in_x = WithinBand(from.x(), way.x(), low.x(), high.x(), {});
  return in_x.empty() ? in_x : WithinBand(from.y(), way.y(), low.y(), high.y(), in_x);
}

Interval WithinDisc(const Vec2& from, const Vec2& way, const Vec2& centre,
                    double radius) {
  const Vec2 away = from - centre;
  const double a = way.squaredNorm(), b = away.dot(way);
  const double c = away.squaredNorm() - radius * radius;
  if (a == 0) return c <= 0 ? Interval{} : Interval{1, 0};
  const double root = b * b - a * c;
  if (root < 0) return {1, 0};
  return {std::max(0.0, (-b - std::sqrt(root)) / a),
          std::min(1.0, (-b + std::sqrt(root)) / a)};
}

/// Where the way is within `radius` of the box, seen from above.
Interval Beside(const Vec2& from, const Vec2& way, const Box3& box, double radius) {
  if (!std::isfinite(radius)) return {};
  const Vec2 low = box.min_mm.head<2>(), high = box.max_mm.head<2>();
  Interval hull{1, 0};
  const auto add = [&hull](const Interval& part) {
    if (part.empty()) return;
    hull = hull.empty()
               ? part
               : Interval{std::min(hull.from, part.from), std::max(hull.to, part.to)};
  };
  const Vec2 along_x(radius, 0), along_y(0, radius);
  add(WithinRectangle(from, way, low - along_x, high + along_x));
  add(WithinRectangle(from, way, low - along_y, high + along_y));
  for (const double x : {low.x(), high.x()}) {
    for (const double y : {low.y(), high.y()}) {
      if (std::isfinite(x) && std::isfinite(y))
        add(WithinDisc(from, way, Vec2(x, y), radius));
    }
  }
  return hull;
}

}  // namespace

Clearance::Clearance(std::vector<BeamBody> bodies, std::vector<Box3> solids)
    : bodies_(std::move(bodies)), solids_(std::move(solids)) {
  for (const BeamBody& body : bodies_) {
    Require(std::isfinite(body.bottom_above_focus_mm) && body.radius_mm >= 0,
            "a body {} mm above the focus with a radius of {} mm",
            body.bottom_above_focus_mm, body.radius_mm);
  }
  for (const Box3& solid : solids_) Require(!solid.empty(), "a solid that is empty");
}

std::optional<Collision> Clearance::Along(const Vec3& from_mm, const Vec3& to_mm) const {
  std::optional<Collision> worst;
  const Vec3 way_mm = to_mm - from_mm;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    for (std::size_t s = 0; s < solids_.size(); ++s) {
      const double lowest_mm =
          std::min(from_mm.z(), to_mm.z()) + bodies_[b].bottom_above_focus_mm;
      const double top_mm = solids_[s].max_mm.z();
      const double best_mm = worst ? worst->overlap_mm : kTouchMm;
      if (!(top_mm - lowest_mm > best_mm)) continue;
      const Interval t =
          Beside(from_mm.head<2>(), way_mm.head<2>(), solids_[s], bodies_[b].radius_mm);
      if (t.empty()) continue;
      const Vec3 deepest_mm = from_mm + (way_mm.z() < 0 ? t.to : t.from) * way_mm;
      const double overlap_mm =
          top_mm - bodies_[b].bottom_above_focus_mm - deepest_mm.z();
      if (overlap_mm > best_mm) worst = Collision{b, s, overlap_mm, deepest_mm};
    }
  }
  return worst;
}

}  // namespace intaglio::machine
