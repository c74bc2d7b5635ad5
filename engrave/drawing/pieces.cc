#include "engrave/drawing/pieces.h"

#include <algorithm>
#include <cmath>

namespace intaglio::drawing {
namespace {

template <typename... Ts>
struct Overloaded : Ts... {
  using Ts::operator()...;
};
template <typename... Ts>
Overloaded(Ts...) -> Overloaded<Ts...>;

double WeightOf(const Nurbs& nurbs, std::size_t i) {
  return nurbs.weights.empty() ? 1.0 : nurbs.weights[i];
}

/// Index of the knot span with u: knots[span] <= u < knots[span + 1], the last span for
/// the end of the range.
std::size_t SpanOf(const Nurbs& nurbs, double u) {
  const auto degree = static_cast<std::size_t>(nurbs.degree);
  const auto first = nurbs.knots.begin() + nurbs.degree;
  const auto last =
      nurbs.knots.begin() + static_cast<std::ptrdiff_t>(nurbs.control_mm.size());
  const auto above = std::upper_bound(first, last, u);
  const auto span = static_cast<std::size_t>(above - nurbs.knots.begin()) - 1;
  return std::clamp(span, degree, nurbs.control_mm.size() - 1);
}

}  // namespace

Vec3 PointAt(const EllipticArc& arc, double t) {
  const double angle = arc.begin_rad + t * arc.sweep_rad;
  return arc.center_mm + arc.axis_u_mm * std::cos(angle) +
         arc.axis_v_mm * std::sin(angle);
}

Vec3 PointAt(const CubicBezier& bezier, double t) {
  const double s = 1 - t;
  const auto& c = bezier.control_mm;
  return c[0] * (s * s * s) + c[1] * (3 * s * s * t) + c[2] * (3 * s * t * t) +
         c[3] * (t * t * t);
}

// De Boor's algorithm on homogeneous coordinates (de Boor 1978, ch. X).
Eigen::Vector4d BlossomOf(const Nurbs& nurbs, std::size_t span,
                          std::span<const double> arguments) {
  const auto degree = static_cast<std::size_t>(nurbs.degree);
  std::vector<Eigen::Vector4d> d(degree + 1);
  for (std::size_t j = 0; j <= degree; ++j) {
    const std::size_t i = span - degree + j;
    const double w = WeightOf(nurbs, i);
    d[j] << nurbs.control_mm[i] * w, w;
  }
  for (std::size_t level = 1; level <= degree; ++level) {
    for (std::size_t j = degree; j >= level; --j) {
      const std::size_t i = span - degree + j;
      const double low = nurbs.knots[i];
      const double width = nurbs.knots[i + degree + 1 - level] - low;
      const double share = width > 0 ? (arguments[level - 1] - low) / width : 0;
      d[j] = (1 - share) * d[j - 1] + share * d[j];
    }
  }
  return d[degree];
}

Vec3 PointAtKnot(const Nurbs& nurbs, double u) {
  const std::vector<double> arguments(static_cast<std::size_t>(nurbs.degree), u);
  const Eigen::Vector4d point = BlossomOf(nurbs, SpanOf(nurbs, u), arguments);
  return point.head<3>() / point.w();
}

Vec3 BeginOf(const Piece& piece) {
  return std::visit(
      Overloaded{[](const Polyline& line) { return line.points_mm.front(); },
                 [](const EllipticArc& arc) { return PointAt(arc, 0); },
                 [](const CubicBezier& bezier) { return bezier.control_mm.front(); },
                 [](const Nurbs& nurbs) {
                   return PointAtKnot(
                       nurbs, nurbs.knots[static_cast<std::size_t>(nurbs.degree)]);
                 }},
      piece);
}

Vec3 EndOf(const Piece& piece) {
  return std::visit(
      Overloaded{[](const Polyline& line) { return line.points_mm.back(); },
                 [](const EllipticArc& arc) { return PointAt(arc, 1); },
                 [](const CubicBezier& bezier) { return bezier.control_mm.back(); },
                 [](const Nurbs& nurbs) {
                   return PointAtKnot(nurbs, nurbs.knots[nurbs.control_mm.size()]);
                 }},
      piece);
}

std::size_t PointCountOf(const Piece& piece) {
  return std::visit(
      Overloaded{[](const Polyline& line) { return line.points_mm.size(); },
                 [](const EllipticArc&) { return std::size_t{3}; },
                 [](const CubicBezier&) { return std::size_t{4}; },
                 [](const Nurbs& nurbs) { return nurbs.control_mm.size(); }},
      piece);
}

void Transform(const Mat3& linear, const Vec3& offset_mm, Piece& piece) {
  const auto place = [&](Vec3& p) { p = linear * p + offset_mm; };
  std::visit(
      Overloaded{
          [&](Polyline& line) { std::ranges::for_each(line.points_mm, place); },
          [&](EllipticArc& arc) {
            place(arc.center_mm);
            arc.axis_u_mm = linear * arc.axis_u_mm;
            arc.axis_v_mm = linear * arc.axis_v_mm;
          },
          [&](CubicBezier& bezier) { std::ranges::for_each(bezier.control_mm, place); },
          [&](Nurbs& nurbs) { std::ranges::for_each(nurbs.control_mm, place); }},
      piece);
}

void Transform(const Mat3& linear, const Vec3& offset_mm, Drawing& drawing) {
  for (Curve& curve : drawing.curves) {
    for (Piece& piece : curve.pieces) Transform(linear, offset_mm, piece);
  }
}

bool WithinReach(const Piece& piece, double max_coordinate_mm) {
  // A comparison with NaN is false, and so is one of infinity: both are refused.
  const auto near = [&](const Vec3& p) {
    return p.cwiseAbs().maxCoeff() <= max_coordinate_mm && p.allFinite();
  };
  const auto finite = [](double x) { return std::isfinite(x); };
  return std::visit(Overloaded{[&](const Polyline& line) {
                                 return std::ranges::all_of(line.points_mm, near);
                               },
                               [&](const EllipticArc& arc) {
                                 return near(arc.center_mm) && near(arc.axis_u_mm) &&
                                        near(arc.axis_v_mm) && finite(arc.begin_rad) &&
                                        finite(arc.sweep_rad);
                               },
                               [&](const CubicBezier& bezier) {
                                 return std::ranges::all_of(bezier.control_mm, near);
                               },
                               [&](const Nurbs& nurbs) {
                                 return std::ranges::all_of(nurbs.control_mm, near) &&
                                        std::ranges::all_of(nurbs.knots, finite) &&
                                        std::ranges::all_of(nurbs.weights, finite);
                               }},
                    piece);
}

}  // namespace intaglio::drawing
