#include "tests/bench/contour_peers.h"

#ifdef INTAGLIO_HAS_CGAL

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/General_polygon_set_2.h>
#include <CGAL/Gps_circle_segment_traits_2.h>

#include <cmath>
#include <list>
#include <numbers>

namespace intaglio::bench {
namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Traits = CGAL::Gps_circle_segment_traits_2<Kernel>;
using PolygonSet = CGAL::General_polygon_set_2<Traits>;
using Polygon = Traits::General_polygon_2;
using PolygonWithHoles = Traits::General_polygon_with_holes_2;
using Curve = Traits::Curve_2;
using MonotoneCurve = Traits::X_monotone_curve_2;
using Number = Kernel::FT;
using Point = Kernel::Point_2;
using ArcPoint = Traits::Point_2;

void Append(const Curve& curve, Polygon& polygon) {
  std::list<CGAL::Object> parts;
  Traits().make_x_monotone_2_object()(curve, std::back_inserter(parts));
  for (const CGAL::Object& part : parts) {
    MonotoneCurve monotone;
    if (CGAL::assign(monotone, part)) polygon.push_back(monotone);
  }
}

Polygon Disc(const Point& center, const Number& radius) {
  Polygon polygon;
  Append(Curve(Kernel::Circle_2(center, radius * radius, CGAL::COUNTERCLOCKWISE)),
         polygon);
  return polygon;
}

Polygon Straight(const std::vector<Point>& corners) {
  Polygon polygon;
  for (std::size_t k = 0; k < corners.size(); ++k)
    polygon.push_back(MonotoneCurve(corners[k], corners[(k + 1) % corners.size()]));
  return polygon;
}

Polygon Stadium(const Point& a, const Point& b, const Number& h) {
  const double angle =
      std::atan2(CGAL::to_double(b.y() - a.y()), CGAL::to_double(b.x() - a.x()));
  // The unit vector to the angle's half-way tangent t: ((1 - t^2), 2 t) / (1 + t^2).
  const double half = angle / 2;
  const bool steep = std::abs(half) > std::numbers::pi / 4;
  const Number t(steep ? 1 / std::tan(half) : std::tan(half));
  const Number d = 1 + t * t;
  const Number x = steep ? Number((t * t - 1) / d) : Number((1 - t * t) / d);
  const Number y = 2 * t / d;
  const Kernel::Vector_2 right(h * y, -h * x);
  const Number h2 = h * h;
  Polygon polygon;
  Append(Curve(a + right, b + right), polygon);
  Append(Curve(Kernel::Circle_2(b, h2, CGAL::COUNTERCLOCKWISE),
               ArcPoint((b + right).x(), (b + right).y()),
               ArcPoint((b - right).x(), (b - right).y())),
         polygon);
  Append(Curve(b - right, a - right), polygon);
  Append(Curve(Kernel::Circle_2(a, h2, CGAL::COUNTERCLOCKWISE),
               ArcPoint((a - right).x(), (a - right).y()),
               ArcPoint((a + right).x(), (a + right).y())),
         polygon);
  return polygon;
}

Point PointOf(const Vec2& place) { return {place.x(), place.y()}; }

Polygon PolygonOf(const contour::Shape& shape, double r) {
  if (const auto* s = std::get_if<contour::Circle>(&shape))
    return Disc(PointOf(s->center_mm), s->diameter_mm / 2 + r);
  if (const auto* s = std::get_if<contour::Track>(&shape))
    return Stadium(PointOf(s->begin_mm), PointOf(s->end_mm), s->width_mm / 2 + r);
  const auto* square = std::get_if<contour::Square>(&shape);
  const auto* octagon = std::get_if<contour::Octagon>(&shape);
  const double half = (square != nullptr ? square->side_mm : octagon->size_mm) / 2 + r;
  const double k = square != nullptr ? half : half * std::tan(std::numbers::pi / 8);
  const Vec2 c = square != nullptr ? square->center_mm : octagon->center_mm;
  const auto at = [&](double x, double y) { return PointOf(c + Vec2(x, y)); };
  if (square != nullptr)
    return Straight({at(-half, -half), at(half, -half), at(half, half), at(-half, half)});
  return Straight({at(-k, -half), at(k, -half), at(half, -k), at(half, k), at(k, half),
                   at(-k, half), at(-half, k), at(-half, -k)});
}

double AreaOf(const Polygon& polygon) {
  double twice = 0;
  for (auto curve = polygon.curves_begin(); curve != polygon.curves_end(); ++curve) {
    const Vec2 a(CGAL::to_double(curve->source().x()),
                 CGAL::to_double(curve->source().y()));
    const Vec2 b(CGAL::to_double(curve->target().x()),
                 CGAL::to_double(curve->target().y()));
    if ((a - b).norm() < 1e-9) continue;  // an arc too short for doubles
    if (curve->is_linear()) {
      twice += contour::Cross(a, b);
      continue;
    }
    const auto& circle = curve->supporting_circle();
    const Vec2 c(CGAL::to_double(circle.center().x()),
                 CGAL::to_double(circle.center().y()));
    twice += contour::TwiceSweptArea(
        contour::MakeArcBetween(a, b, c, curve->orientation() == CGAL::COUNTERCLOCKWISE));
  }
  return twice / 2;
}

}  // namespace

std::optional<PeerUnion> UniteByCgal(std::span<const contour::Element> elements,
                                     double tool_radius_mm) {
  std::vector<Polygon> polygons;
  for (const contour::Element& element : elements)
    polygons.push_back(PolygonOf(element.shape, tool_radius_mm));
  PeerUnion result;
  const double begin = ProcessorSeconds();
  PolygonSet set;
  set.join(polygons.begin(), polygons.end());
  std::vector<PolygonWithHoles> parts;
  set.polygons_with_holes(std::back_inserter(parts));
  result.seconds = ProcessorSeconds() - begin;
  for (const PolygonWithHoles& part : parts) {
    result.area_mm2 += AreaOf(part.outer_boundary());
    ++result.contours;
    for (auto hole = part.holes_begin(); hole != part.holes_end(); ++hole) {
      result.area_mm2 += AreaOf(*hole);
      ++result.contours;
    }
  }
  return result;
}

}  // namespace intaglio::bench

#else

namespace intaglio::bench {

std::optional<PeerUnion> UniteByCgal(std::span<const contour::Element>, double) {
  return std::nullopt;
}

}  // namespace intaglio::bench

#endif
