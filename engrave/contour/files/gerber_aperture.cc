#include "engrave/contour/files/gerber_aperture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "engrave/core/convex_hull.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;
constexpr double kMaxAperture_mm = 10'000;

Edges Straight(const std::vector<Vec2>& corners) {
  Edges edges;
  for (std::size_t k = 0; k < corners.size(); ++k)
    edges.push_back(MakeLine(corners[k], corners[(k + 1) % corners.size()]));
  return edges;
}

Edges BoxEdges(const Vec2& half) {
  return Straight(
      {{-half.x(), -half.y()}, {half.x(), -half.y()}, half, {-half.x(), half.y()}});
}

Edges RegularEdges(int count, double diameter, double turned_rad) {
  std::vector<Vec2> corners;
  for (int k = 0; k < count; ++k) {
    const double angle = turned_rad + 2 * pi * k / count;
    corners.push_back(diameter / 2 * Vec2(std::cos(angle), std::sin(angle)));
  }
  return Straight(corners);
}

/// The outline of an obround, for those with a hole.
Edges ObroundEdges(const Vec2& sides) {
  const double r = sides.minCoeff() / 2;
  const bool wide = sides.x() > sides.y();
  const Vec2 end = wide ? Vec2(sides.x() / 2 - r, 0) : Vec2(0, sides.y() / 2 - r);
  const double begin = wide ? -pi / 2 : 0;
  const Edge first = MakeArc(end, r, begin, pi);
  const Edge second = MakeArc(-end, r, begin + pi, pi);
  return {first, MakeLine(first.end_mm, second.begin_mm), second,
          MakeLine(second.end_mm, first.begin_mm)};
}

struct OfKind {
  std::size_t size_count;  ///< numbers before the hole
  const char* sentence;
};

Result<OfKind> KindOf(char kind) {
  switch (kind) {
    case 'C':
      return OfKind{1, "a circle needs a diameter"};
    case 'R':
      return OfKind{2, "a rectangle needs two sides"};
    case 'O':
      return OfKind{2, "an obround needs two sides"};
    case 'P':
      return OfKind{2, "a polygon needs a diameter and 3 to 12 corners"};
    default:
      return Fail(ErrorCode::kMissing, "the aperture's macro is not defined");
  }
}

Edges StandardEdges(char kind, double a, double b, const std::vector<double>& n) {
  if (kind == 'R') return BoxEdges(Vec2(a, b) / 2);
  if (kind == 'P')
    return RegularEdges(static_cast<int>(n[1]), a, n.size() > 2 ? n[2] * pi / 180 : 0);
  if (kind == 'O' && a != b) return ObroundEdges({a, b});
  return {MakeArc(Vec2::Zero(), a / 2, 0, 2 * pi)};
}

/// The simplest shape: an outline only where nothing else fits.
Shape StandardShape(char kind, double a, double b, const std::vector<double>& n,
                    double hole) {
  if (hole > 0)
    return Outline{
        {StandardEdges(kind, a, b, n), {MakeArc(Vec2::Zero(), hole / 2, 0, 2 * pi)}}};
  if (kind == 'C' || (kind == 'O' && a == b)) return Circle{Vec2::Zero(), a};
  if (kind == 'R' && a == b) return Square{Vec2::Zero(), a};
  if (kind == 'O') {
    const Vec2 end = a > b ? Vec2((a - b) / 2, 0) : Vec2(0, (b - a) / 2);
    return Track{-end, end, std::min(a, b)};
  }
  return Outline{{StandardEdges(kind, a, b, n)}};
}

}  // namespace

Result<GerberAperture> StandardAperture(char kind, const std::vector<double>& numbers,
                                        double unit_mm) {
  const OfKind of = INTAGLIO_TRY(KindOf(kind));
  const std::size_t before_hole = of.size_count + (kind == 'P' ? 1 : 0);
  if (numbers.size() < of.size_count || numbers.size() > before_hole + 2)
    return Fail(ErrorCode::kInvalidValue, of.sentence);
  for (std::size_t k = 0; k < of.size_count; ++k) {
    const bool corners = kind == 'P' && k == 1;
    const double size = corners ? numbers[k] : numbers[k] * unit_mm;
    const bool zero_circle = kind == 'C' && size == 0;
    if (!(size > 0 || zero_circle) || size > kMaxAperture_mm ||
        (corners && (size < 3 || size > 12 || size != std::floor(size))))
      return Fail(ErrorCode::kInvalidValue, of.sentence);
  }
  if (numbers.size() > before_hole + 1)
    return Fail(ErrorCode::kUnsupported, "rectangular holes of apertures are not read");
  GerberAperture aperture;
  const bool has_hole = numbers.size() == before_hole + 1 && numbers.back() != 0;
  const double hole = has_hole ? numbers.back() * unit_mm : 0;
  if (hole < 0 || (has_hole && hole >= numbers[0] * unit_mm))
    return Fail(ErrorCode::kInvalidValue, "a hole has to be smaller than its aperture");
  if (numbers[0] == 0) {
    aperture.draw_width_mm = 0;  // shapes without a size: flashes of it are nothing
    return aperture;
  }
  const double a = numbers[0] * unit_mm;
  const double b = numbers.size() > 1 ? numbers[1] * unit_mm : a;
  aperture.shapes.push_back(StandardShape(kind, a, b, numbers, hole));
  if (kind == 'C' && !has_hole) aperture.draw_width_mm = a;
  if (kind == 'R' && !has_hole) aperture.draw_box_mm = {a, b};
  return aperture;
}

namespace {

Edge MovedEdge(Edge edge, const Vec2& by) {
  edge.begin_mm += by;
  edge.end_mm += by;
  edge.center_mm += by;
  return edge;
}

struct Mover {
  Vec2 by;
  Shape operator()(Circle s) const {
    s.center_mm += by;
    return s;
  }
  Shape operator()(Square s) const {
    s.center_mm += by;
    return s;
  }
  Shape operator()(Octagon s) const {
    s.center_mm += by;
    return s;
  }
  Shape operator()(Track s) const {
    s.begin_mm += by;
    s.end_mm += by;
    return s;
  }
  Shape operator()(ArcTrack s) const {
    s.arc = MovedEdge(s.arc, by);
    return s;
  }
  Shape operator()(Outline s) const {
    for (Edges& loop : s.loops) {
      for (Edge& edge : loop) edge = MovedEdge(edge, by);
    }
    return s;
  }
};

}  // namespace

Shape Moved(const Shape& shape, const Vec2& by_mm) {
  return std::visit(Mover{by_mm}, shape);
}

Outline SweptBox(const Vec2& sides_mm, const Vec2& from_mm, const Vec2& to_mm) {
  // The corners of both boxes that lie outermost.
  std::vector<Vec2> corners;
  for (const Vec2& center : {from_mm, to_mm}) {
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5})
        corners.push_back(center + Vec2(x * sides_mm.x(), y * sides_mm.y()));
    }
  }
  return {{Straight(ConvexHull(std::move(corners)))}};
}

}  // namespace intaglio::contour
