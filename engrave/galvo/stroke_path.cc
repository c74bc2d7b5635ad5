#include "engrave/galvo/stroke_path.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engrave/core/check.h"

namespace intaglio::galvo {
namespace {

// Above the turns of arcs that were flattened to a micrometre, below any corner that is
// seen: 20 degrees.
constexpr double kCornerRad = 0.35;

/// The turn of a corner; 0: there is none. The tangent of the turn shows that without its
/// angle, but near the limit.
double CornerAt(const Vec2& before, const Vec2& at, const Vec2& after) {
  constexpr double kSurelyNone = 0.36;  // below the tangent of the corner, 0.365
  const Vec2 in = at - before, out = after - at;
  const double across = in.x() * out.y() - in.y() * out.x(), along = in.dot(out);
  if (std::abs(across) < kSurelyNone * along) return 0;
  const double turn_rad = std::abs(std::atan2(across, along));
  return turn_rad > kCornerRad ? turn_rad : 0;
}

/// Without places that coincide with the one before.
std::vector<Vec2> Distinct(const MarkStroke& stroke) {
  std::vector<Vec2> points;
  points.reserve(stroke.points_mm.size() + 1);
  for (const Vec2& p : stroke.points_mm)
    if (points.empty() || p != points.back()) points.push_back(p);
  while (stroke.closed && points.size() > 1 && points.back() == points.front())
    points.pop_back();
  return points;
}

std::vector<StrokePart> Whole(std::vector<Vec2> points, bool closed) {
  std::vector<StrokePart> whole(1);
  whole.front() = {std::move(points), closed, 0};
  return whole;
}

}  // namespace

StrokePath::StrokePath(std::vector<Vec2> points_mm, bool closed)
    : points_mm_(std::move(points_mm)), closed_(closed) {
  if (closed_) points_mm_.push_back(points_mm_.front());
  ends_mm_.reserve(points_mm_.size());
  double sum_mm = 0;
  for (std::size_t i = 0; i < points_mm_.size(); ++i) {
    if (i > 0) sum_mm += (points_mm_[i] - points_mm_[i - 1]).norm();
    ends_mm_.push_back(sum_mm);
  }
  Require(sum_mm > 0, "a stroke of {} places has no length", points_mm_.size());
}

double StrokePath::Within(double along_mm) const {
  if (!closed_) return along_mm;
  const double turns = std::floor(along_mm / length_mm());
  return along_mm - turns * length_mm();
}

std::size_t StrokePath::SegmentAt(double along_mm) const {
  if (along_mm < ends_mm_[last_]) last_ = 0;
  while (last_ + 2 < ends_mm_.size() && along_mm >= ends_mm_[last_ + 1]) ++last_;
  return last_;
}

Vec2 StrokePath::At(double along_mm) const {
  const double s = Within(along_mm);
  const std::size_t i = SegmentAt(s);
  const double share = (s - ends_mm_[i]) / (ends_mm_[i + 1] - ends_mm_[i]);
  return points_mm_[i] + share * (points_mm_[i + 1] - points_mm_[i]);
}

Vec2 StrokePath::DirectionAt(double along_mm) const {
  const std::size_t i = SegmentAt(Within(along_mm));
  return (points_mm_[i + 1] - points_mm_[i]).normalized();
}

std::vector<StrokePart> PartsOf(const MarkStroke& stroke) {
  std::vector<Vec2> points = Distinct(stroke);
  const std::size_t n = points.size();
  if (n < 2) return {};
  if (n == 2 && !stroke.closed) return Whole(std::move(points), false);
  std::vector<double> turns(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i)
    turns[i] = CornerAt(points[i - 1], points[i], points[i + 1]);
  if (stroke.closed) {
    turns.front() = CornerAt(points.back(), points.front(), points[1]);
    turns.back() = CornerAt(points[n - 2], points.back(), points.front());
  }
  const auto corner =
      std::ranges::find_if(turns, [](double turn_rad) { return turn_rad > 0; });
  if (corner == turns.end()) return Whole(std::move(points), stroke.closed);
  if (stroke.closed) {  // begins and ends at a corner: the first place if it is one
    const auto by = corner - turns.begin();
    std::rotate(points.begin(), points.begin() + by, points.end());
    std::rotate(turns.begin(), turns.begin() + by, turns.end());
    points.push_back(points.front());
    turns.push_back(0);
    turns.front() = 0;
  }
  std::vector<StrokePart> parts(1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    parts.back().points_mm.push_back(points[i]);
    if (turns[i] == 0) continue;
    parts.back().turn_rad = turns[i];
    parts.push_back({{points[i]}, false, 0});
  }
  return parts;
}

}  // namespace intaglio::galvo
