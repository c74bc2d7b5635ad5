#include "engrave/drawing/control_polygon.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "engrave/core/segment.h"
#include "engrave/drawing/pieces.h"

namespace intaglio::drawing {

ControlPolygon::ControlPolygon(const CubicBezier& bezier) : degree_(3) {
  for (std::size_t i = 0; i <= degree_; ++i) points_[i] << bezier.control_mm[i], 1;
}

// Its control points are the values of the span's blossom at both ends.
ControlPolygon::ControlPolygon(const Nurbs& nurbs, std::size_t span)
    : degree_(static_cast<std::size_t>(nurbs.degree)) {
  std::vector<double> arguments(degree_, nurbs.knots[span]);
  for (std::size_t i = 0; i <= degree_; ++i) {
    points_[i] = BlossomOf(nurbs, span, arguments);
    if (i < degree_) arguments[i] = nurbs.knots[span + 1];
  }
}

ControlPolygon::ControlPolygon(const ControlPolygon& other) { *this = other; }

ControlPolygon& ControlPolygon::operator=(const ControlPolygon& other) {
  degree_ = other.degree_;
  std::copy_n(other.points_.begin(), degree_ + 1, points_.begin());
  return *this;
}

std::pair<ControlPolygon, ControlPolygon> ControlPolygon::SplitAt(double share) const {
  std::pair<ControlPolygon, ControlPolygon> parts{ControlPolygon(degree_), *this};
  auto& rest = parts.second.points_;
  for (std::size_t level = 0; level <= degree_; ++level) {
    parts.first.points_[level] = rest[0];
    for (std::size_t i = 0; i + level < degree_; ++i)
      rest[i] = (1 - share) * rest[i] + share * rest[i + 1];
  }
  return parts;
}

// Who never turns back on the way along the chord is beside it all the way, so the
// distance from its line is that from the chord.
bool ControlPolygon::FollowsChord(double tolerance_mm) const {
  const Vec3 from = Place(0), chord = Place(degree_) - from;
  const double limit_mm = tolerance_mm / Share();
  const double limit_mm2 = limit_mm * limit_mm, chord_mm2 = chord.squaredNorm();
  double before = 0;
  for (std::size_t i = 1; i <= degree_; ++i) {
    const Vec3 way = Place(i) - from;
    const double along = way.dot(chord), excess_mm2 = way.squaredNorm() - limit_mm2;
    if (along < before) return false;
    if (excess_mm2 > 0 && excess_mm2 * chord_mm2 >= along * along) return false;
    before = along;
  }
  return true;
}

bool ControlPolygon::IsWithin(double distance_mm) const {
  const Vec3 from = Place(0);
  for (std::size_t i = 1; i <= degree_; ++i) {
    if ((Place(i) - from).norm() > distance_mm) return false;
  }
  return true;
}

// Both ends lie on the chord, and have a share of each point of the curve: in its middle,
// where it is smallest, both together 2^(1 - degree) by equal weights.
double ControlPolygon::Share() const {
  double greatest = 0;
  for (std::size_t i = 0; i <= degree_; ++i)
    greatest = std::max(greatest, points_[i].w());
  const double ends = std::min(points_[0].w(), points_[degree_].w()) / greatest;
  return degree_ == 1 ? 1 : 1 - std::ldexp(ends, 1 - static_cast<int>(degree_));
}

std::pair<ArcPart, ArcPart> ArcPart::SplitAt(double share) const {
  const double middle = begin_ + share * (end_ - begin_);
  return {ArcPart(*arc_, begin_, middle), ArcPart(*arc_, middle, end_)};
}

bool ArcPart::FollowsChord(double tolerance_mm) const {
  const Vec3 from = PointAt(*arc_, begin_), to = PointAt(*arc_, end_);
  const auto goes_on = [&](double t) {
    const double angle = arc_->begin_rad + t * arc_->sweep_rad;
    const Vec3 tangent =
        arc_->axis_v_mm * std::cos(angle) - arc_->axis_u_mm * std::sin(angle);
    return arc_->sweep_rad * tangent.dot(to - from) >= 0;
  };
  const Vec3 middle = PointAt(*arc_, 0.5 * (begin_ + end_));
  return goes_on(begin_) && goes_on(end_) &&
         SquaredDistanceFromSegment(middle, from, to) <= tolerance_mm * tolerance_mm;
}

}  // namespace intaglio::drawing
