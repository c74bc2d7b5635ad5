#include "tests/engrave/contour/covered_area.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace intaglio::contour::test {
namespace {

using std::numbers::pi;
using Interval = std::pair<double, double>;

/// All points nearer than h to the convex hull of the corners.
struct Convex {
  std::vector<Vec2> corners;
  double h = 0;

  std::optional<Interval> At(double y) const {
    Interval found{1e300, -1e300};
    const auto extend = [&](double x) {
      found = {std::min(found.first, x), std::max(found.second, x)};
    };
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const Vec2& a = corners[k];
      if (const double off = y - a.y(); std::abs(off) < h) {
        extend(a.x() - std::sqrt(h * h - off * off));
        extend(a.x() + std::sqrt(h * h - off * off));
      }
      const Vec2& b = corners[(k + 1) % corners.size()];
      if (a == b) continue;
      // Both sides of the strip about a side; of one without width the side itself.
      const Vec2 normal = h * Vec2(b.y() - a.y(), a.x() - b.x()).normalized();
      for (const double side : {-1.0, 1.0}) {
        const Vec2 p = a + side * normal;
        const Vec2 q = b + side * normal;
        if ((p.y() <= y) == (q.y() <= y)) continue;
        extend(p.x() + (q.x() - p.x()) * (y - p.y()) / (q.y() - p.y()));
      }
    }
    if (found.first > found.second) return std::nullopt;
    return found;
  }
};

Convex ConvexOf(const Shape& shape, double r) {
  if (const auto* s = std::get_if<Circle>(&shape))
    return {{s->center_mm}, s->diameter_mm / 2 + r};
  if (const auto* s = std::get_if<Track>(&shape))
    return {{s->begin_mm, s->end_mm}, s->width_mm / 2 + r};
  Convex polygon;
  const auto* square = std::get_if<Square>(&shape);
  const auto* octagon = std::get_if<Octagon>(&shape);
  const int count = square != nullptr ? 4 : 8;
  const double half = (square != nullptr ? square->side_mm : octagon->size_mm) / 2 + r;
  const Vec2 center = square != nullptr ? square->center_mm : octagon->center_mm;
  for (int k = 0; k < count; ++k) {
    const double angle = (2 * k + 1) * pi / count;
    polygon.corners.push_back(center + half / std::cos(pi / count) *
                                           Vec2(std::cos(angle), std::sin(angle)));
  }
  return polygon;
}

/// A line through two points, or a circle.
struct Carrier {
  Vec2 a;
  Vec2 b;
  double radius = 0;  ///< of a circle about a
};

std::vector<Carrier> CarriersOf(const Convex& c) {
  std::vector<Carrier> carriers;
  for (std::size_t k = 0; k < c.corners.size(); ++k) {
    const Vec2& a = c.corners[k];
    const Vec2& b = c.corners[(k + 1) % c.corners.size()];
    if (c.h > 0) carriers.push_back({a, a, c.h});
    if (a == b) continue;
    const Vec2 normal = c.h * Vec2(b.y() - a.y(), a.x() - b.x()).normalized();
    carriers.push_back({a + normal, b + normal});
  }
  return carriers;
}

void AddLineCircle(const Carrier& line, const Carrier& circle,
                   std::vector<double>& heights) {
  const Vec2 u = (line.b - line.a).normalized();
  const double along = (circle.a - line.a).dot(u);
  const Vec2 foot = line.a + along * u;
  const double half2 = circle.radius * circle.radius - (circle.a - foot).squaredNorm();
  if (half2 < -1e-9) return;
  const double half = std::sqrt(std::max(half2, 0.0));
  heights.push_back((foot + half * u).y());
  heights.push_back((foot - half * u).y());
}

void AddMeetings(const Carrier& p, const Carrier& q, std::vector<double>& heights) {
  if (p.radius == 0 && q.radius == 0) {
    const Vec2 u = p.b - p.a;
    const Vec2 v = q.b - q.a;
    const double turn = u.x() * v.y() - u.y() * v.x();
    const Vec2 w = q.a - p.a;
    if (std::abs(turn) > 1e-12 * u.norm() * v.norm())
      heights.push_back(p.a.y() + (w.x() * v.y() - w.y() * v.x()) / turn * u.y());
  } else if (p.radius == 0) {
    AddLineCircle(p, q, heights);
  } else if (q.radius == 0) {
    AddLineCircle(q, p, heights);
  } else {
    const Vec2 d = q.a - p.a;
    if (d.norm() < 1e-9) return;
    // The line through both meetings: 2 d x = |q|^2 - |p|^2 + rp^2 - rq^2.
    const double along =
        (d.squaredNorm() + p.radius * p.radius - q.radius * q.radius) / (2 * d.norm());
    const Vec2 foot = p.a + along * d.normalized();
    AddLineCircle({foot, foot + Vec2(-d.y(), d.x())}, p, heights);
  }
}

bool MayMeet(const Convex& p, const Convex& q) {
  const Vec2 center = p.corners[0] - q.corners[0];
  double far_p = 0;
  double far_q = 0;
  for (const Vec2& corner : p.corners)
    far_p = std::max(far_p, (corner - p.corners[0]).norm());
  for (const Vec2& corner : q.corners)
    far_q = std::max(far_q, (corner - q.corners[0]).norm());
  return center.norm() < p.h + q.h + far_p + far_q + 1e-3;
}

std::vector<double> Heights(const std::vector<Convex>& all) {
  std::vector<double> heights;
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (const Vec2& corner : all[i].corners) {
      for (const double side : {-1, 0, 1})
        heights.push_back(corner.y() + side * all[i].h);
    }
    const auto carriers = CarriersOf(all[i]);
    for (const Carrier& c : carriers) {
      heights.push_back(c.a.y());
      heights.push_back(c.b.y());
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (!MayMeet(all[i], all[j])) continue;
      for (const Carrier& q : CarriersOf(all[j])) {
        for (const Carrier& p : carriers) AddMeetings(p, q, heights);
      }
    }
  }
  std::sort(heights.begin(), heights.end());
  return heights;
}

double CoveredLength(const std::vector<Convex>& all, double y,
                     std::vector<Interval>& intervals) {
  intervals.clear();
  for (const Convex& convex : all) {
    if (const auto interval = convex.At(y)) intervals.push_back(*interval);
  }
  std::sort(intervals.begin(), intervals.end());
  double length = 0;
  double end = -1e300;
  for (const Interval& interval : intervals) {
    length += std::max(0.0, interval.second - std::max(interval.first, end));
    end = std::max(end, interval.second);
  }
  return length;
}

/// Nodes and weights of Gauss and Legendre on -1 .. 1 by Newton's method.
std::vector<std::pair<double, double>> Gauss(int count) {
  std::vector<std::pair<double, double>> rule;
  for (int k = 0; k < count; ++k) {
    double x = std::cos(pi * (k + 0.75) / (count + 0.5));
    double slope = 1;
    for (int step = 0; step < 50; ++step) {
      double before = 1;
      double value = x;
      for (int n = 2; n <= count; ++n)
        before = std::exchange(value, ((2 * n - 1) * x * value - (n - 1) * before) / n);
      slope = count * (x * value - before) / (x * x - 1);
      x -= value / slope;
    }
    rule.push_back({x, 2 / ((1 - x * x) * slope * slope)});
  }
  return rule;
}

}  // namespace

double CoveredArea_mm2(std::span<const Element> elements, double tool_radius_mm,
                       int points) {
  std::vector<Convex> all;
  double bottom = 1e300;
  double top = -1e300;
  for (const Element& element : elements) {
    all.push_back(ConvexOf(element.shape, tool_radius_mm));
    for (const Vec2& corner : all.back().corners) {
      bottom = std::min(bottom, corner.y() - all.back().h);
      top = std::max(top, corner.y() + all.back().h);
    }
  }
  const auto rule = Gauss(points);
  const std::vector<double> heights = Heights(all);
  std::vector<Interval> intervals;
  double area = 0;
  double from = bottom;
  for (const double height : heights) {
    const double to = std::min(height, top);
    if (to - from < 1e-6) continue;  // with the next one
    const double half = (to - from) / 2;
    for (const auto& [node, weight] : rule) {
      const double t = pi / 2 * node;
      area += pi / 2 * weight * half * std::cos(t) *
              CoveredLength(all, from + half + half * std::sin(t), intervals);
    }
    from = to;
  }
  return area;
}

}  // namespace intaglio::contour::test
