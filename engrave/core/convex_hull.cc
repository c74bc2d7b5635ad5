// Andrew, Another efficient algorithm for convex hulls in two dimensions, Information
// Processing Letters 9 (1979) 216: the sorted points are passed from left to right and
// back, and a corner goes as soon as it does not turn left.

#include "engrave/core/convex_hull.h"

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"

namespace intaglio {
namespace {

// Less is a line: what rounding makes of one.
constexpr double kFlatMm2 = 1e-12;

/// Twice the area of a triangle; positive: counter-clockwise.
double TwiceArea(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2 along = b - a, to = c - a;
  return along.x() * to.y() - along.y() * to.x();
}

/// How far a corner is from the line through its neighbours.
double HeightOf(const std::vector<Vec2>& corners, std::size_t at) {
  const Vec2& before = corners[(at + corners.size() - 1) % corners.size()];
  const Vec2& after = corners[(at + 1) % corners.size()];
  const double base = (after - before).norm();
  return base > 0 ? std::abs(TwiceArea(before, corners[at], after)) / base
                  : (corners[at] - before).norm();
}

}  // namespace

std::vector<Vec2> ConvexHull(std::vector<Vec2> points) {
  std::sort(points.begin(), points.end(), [](const Vec2& a, const Vec2& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Vec2> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t first = hull.size();
    for (const Vec2& point : points) {
      while (hull.size() >= first + 2 &&
             TwiceArea(hull[hull.size() - 2], hull.back(), point) <= kFlatMm2)
        hull.pop_back();
      hull.push_back(point);
    }
    hull.pop_back();  // the other pass begins with it
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

std::vector<Vec2> WithFewerCorners(std::vector<Vec2> corners, std::size_t max_count) {
  Require(max_count > 0, "{} corners are left", max_count);
  while (corners.size() > max_count) {
    std::size_t flattest = 0;
    for (std::size_t at = 1; at < corners.size(); ++at) {
      if (HeightOf(corners, at) < HeightOf(corners, flattest)) flattest = at;
    }
    corners.erase(corners.begin() + static_cast<std::ptrdiff_t>(flattest));
  }
  return corners;
}

}  // namespace intaglio
