#include <cmath>

#include "engrave/drawing/dxf/dxf_spline.h"

// Hermite form: derivatives m_i at the points p_i, h_i the chord from p_i to p_{i+1}. The
// second derivative is continuous at p_i if
//   m_{i-1} / h_{i-1} + 2 (1 / h_{i-1} + 1 / h_i) m_i + m_{i+1} / h_i
//     = 3 ((p_i - p_{i-1}) / h_{i-1}^2 + (p_{i+1} - p_i) / h_i^2),
// a tridiagonal system, cyclic when the spline is periodic.

namespace intaglio::drawing {
namespace {

struct Row {
  double below = 0;
  double middle = 1;
  double above = 0;
};

/// Gaussian elimination along the three diagonals; they are dominant, so without pivots.
template <typename T>
std::vector<T> SolveTridiagonal(std::vector<Row> rows, std::vector<T> right) {
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double factor = rows[i].below / rows[i - 1].middle;
    rows[i].middle -= factor * rows[i - 1].above;
    right[i] -= factor * right[i - 1];
  }
  right.back() /= rows.back().middle;
  for (std::size_t i = rows.size() - 1; i-- > 0;) {
    right[i] = (right[i] - rows[i].above * right[i + 1]) / rows[i].middle;
  }
  return right;
}

/// Cyclic rows: the first `below` and the last `above` are in the opposite corners of the
/// matrix (Sherman and Morrison 1950).
PointList SolveCyclic(std::vector<Row> rows, const PointList& right) {
  const std::size_t last = rows.size() - 1;
  const double corner = rows.front().below, other = rows[last].above;
  const double shift = -rows.front().middle;
  rows.front().middle -= shift;
  rows[last].middle -= corner * other / shift;
  std::vector<double> unit(rows.size(), 0.0);
  unit.front() = shift;
  unit[last] = other;
  PointList x = SolveTridiagonal(rows, right);
  const std::vector<double> z = SolveTridiagonal(rows, unit);
  const double share = corner / shift;
  const Vec3 factor = (x.front() + share * x[last]) / (1 + z.front() + share * z[last]);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] -= factor * z[i];
  return x;
}

/// Row and right side at p_i, between the chords `before` and `after`.
Row InnerRow(const Vec3& before, const Vec3& after, Vec3& right) {
  const double h = before.norm(), k = after.norm();
  right = 3 * (before / (h * h) + after / (k * k));
  return {1 / h, 2 * (1 / h + 1 / k), 1 / k};
}

PointList Derivatives(const PointList& points, const Vec3& begin_tangent,
                      const Vec3& end_tangent) {
  const std::size_t n = points.size();
  const auto chord = [&](std::size_t i) { return Vec3(points[i + 1] - points[i]); };
  if (n > 3 && points.front() == points.back()) {
    std::vector<Row> rows(n - 1);
    PointList right(n - 1);
    rows[0] = InnerRow(chord(n - 2), chord(0), right[0]);
    for (std::size_t i = 1; i + 1 < n; ++i) {
      rows[i] = InnerRow(chord(i - 1), chord(i), right[i]);
    }
    PointList m = SolveCyclic(std::move(rows), right);
    m.push_back(m.front());
    return m;
  }
  std::vector<Row> rows(n);
  PointList right(n);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    rows[i] = InnerRow(chord(i - 1), chord(i), right[i]);
  }
  if (begin_tangent.norm() > 0) {
    right.front() = begin_tangent.normalized();
  } else {
    rows.front() = {0, 2, 1};
    right.front() = 3 * chord(0).normalized();
  }
  if (end_tangent.norm() > 0) {
    right.back() = end_tangent.normalized();
  } else {
    rows.back() = {1, 2, 0};
    right.back() = 3 * chord(n - 2).normalized();
  }
  return SolveTridiagonal(std::move(rows), std::move(right));
}

}  // namespace

std::vector<Piece> SplineThrough(const PointList& points, const Vec3& begin_tangent,
                                 const Vec3& end_tangent) {
  const PointList m = Derivatives(points, begin_tangent, end_tangent);
  std::vector<Piece> pieces;
  pieces.reserve(points.size() - 1);
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const double third = (points[i + 1] - points[i]).norm() / 3;
    pieces.push_back(CubicBezier{{points[i], points[i] + third * m[i],
                                  points[i + 1] - third * m[i + 1], points[i + 1]}});
  }
  return pieces;
}

}  // namespace intaglio::drawing
