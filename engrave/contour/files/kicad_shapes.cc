#include "engrave/contour/files/kicad_shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;
constexpr double kMaxKicadPlace_mm = 10'000;

tl::unexpected<Error> WrongExpression(const SExpression& in, std::string_view name) {
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("expected ({} ..) with numbers of at most {} mm in ({} ..)",
                          name, kMaxKicadPlace_mm, in.name()));
}

Result<Vec2> PointOf(const SExpression& list) {
  const auto x = list.Number(1);
  const auto y = list.Number(2);
  if (!x || !y || std::abs(*x) > kMaxKicadPlace_mm || std::abs(*y) > kMaxKicadPlace_mm)
    return WrongExpression(list, list.name());
  return Vec2(*x, *y);
}

Edges ClosedPolygon(const std::vector<Vec2>& corners) {
  Edges edges;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Vec2& next = corners[(k + 1) % corners.size()];
    if (next != corners[k]) edges.push_back(MakeLine(corners[k], next));
  }
  return edges;
}

/// Before version 6: (start CENTRE) (end BEGIN) (angle DEGREES), clockwise on the screen
/// with y down, so counter-clockwise when negative.
Result<Edge> OldArc(const SExpression& item, const KicadPlace& place) {
  const Vec2 center = place.Of(INTAGLIO_TRY(KicadPoint(item, "start")));
  const Vec2 begin = place.Of(INTAGLIO_TRY(KicadPoint(item, "end")));
  const double sweep = -INTAGLIO_TRY(KicadNumber(item, "angle", 0)) * pi / 180;
  const Vec2 from = begin - center;
  if (from.norm() == 0 || std::abs(sweep) < 1e-9 || std::abs(sweep) > 2 * pi)
    return WrongExpression(item, "angle");
  return MakeArc(center, from.norm(), std::atan2(from.y(), from.x()), sweep);
}

Result<Edges> EdgesOfGraphic(const SExpression& item, std::string_view kind,
                             const KicadPlace& place) {
  if (kind == "poly") return ClosedPolygon(INTAGLIO_TRY(KicadCorners(item, place)));
  if (kind == "circle") {
    const Vec2 center = place.Of(INTAGLIO_TRY(KicadPoint(item, "center")));
    const Vec2 end = place.Of(INTAGLIO_TRY(KicadPoint(item, "end")));
    if (end == center) return WrongExpression(item, "end");
    return Edges{MakeArc(center, (end - center).norm(), 0, 2 * pi)};
  }
  if (kind == "arc" && !item.Find("mid")) return Edges{INTAGLIO_TRY(OldArc(item, place))};
  const Vec2 start = INTAGLIO_TRY(KicadPoint(item, "start"));
  const Vec2 end = INTAGLIO_TRY(KicadPoint(item, "end"));
  if (kind == "rect")
    return ClosedPolygon({place.Of(start), place.Of({end.x(), start.y()}), place.Of(end),
                          place.Of({start.x(), end.y()})});
  if (kind == "line") return Edges{MakeLine(place.Of(start), place.Of(end))};
  const Vec2 middle = INTAGLIO_TRY(KicadPoint(item, "mid"));
  return Edges{KicadArc(place.Of(start), place.Of(middle), place.Of(end))};
}

/// Sides parallel to the axes of the pad; r: of the corners.
Shape RoundBox(const Vec2& center, const Vec2& sides, double r, double turned) {
  const auto at = [&](double x, double y) -> Vec2 {
    return center + Vec2(x * std::cos(turned) - y * std::sin(turned),
                         x * std::sin(turned) + y * std::cos(turned));
  };
  const Vec2 h = sides / 2;
  const double shortest = h.minCoeff();
  if (r >= shortest * (1 - 1e-9)) {
    if (h.x() == h.y()) return Circle{center, sides.x()};
    const Vec2 end = h.x() > h.y() ? Vec2(h.x() - h.y(), 0) : Vec2(0, h.y() - h.x());
    return Track{at(-end.x(), -end.y()), at(end.x(), end.y()), 2 * shortest};
  }
  const double quarters = turned / (pi / 2);
  if (r <= 0 && h.x() == h.y() && std::abs(quarters - std::round(quarters)) < 1e-9)
    return Square{center, sides.x()};
  Edges edges;
  Vec2 last = at(-h.x() + r, -h.y());
  for (int corner = 0; corner < 4; ++corner) {
    const Vec2 sign(corner < 2 ? 1 : -1, corner == 1 || corner == 2 ? 1 : -1);
    const Vec2 middle = (h - Vec2(r, r)).cwiseProduct(sign);
    const double begin = (corner - 1) * pi / 2;
    const auto on_corner = [&](double angle) {
      return at(middle.x() + r * std::cos(angle), middle.y() + r * std::sin(angle));
    };
    const Vec2 next = on_corner(begin);
    if (next != last) edges.push_back(MakeLine(last, next));
    last = on_corner(begin + pi / 2);
    if (r > 0)
      edges.push_back(MakeArcBetween(next, last, at(middle.x(), middle.y()), true));
  }
  if (last != edges.front().begin_mm)
    edges.push_back(MakeLine(last, edges.front().begin_mm));
  return Outline{{edges}};
}

}  // namespace

Vec2 KicadPlace::Of(const Vec2& file_mm) const {
  const Vec2 up(file_mm.x(), -file_mm.y());
  if (turned_rad == 0) return at_mm + up;
  const double c = std::cos(turned_rad);
  const double s = std::sin(turned_rad);
  return at_mm + Vec2(up.x() * c - up.y() * s, up.x() * s + up.y() * c);
}

Edge KicadArc(const Vec2& begin, const Vec2& middle, const Vec2& end) {
  const Vec2 a = middle - begin;
  const Vec2 b = end - begin;
  const double turn = 2 * Cross(a, b);
  if (std::abs(turn) < 1e-12 * (1 + a.squaredNorm() + b.squaredNorm()))
    return MakeLine(begin, end);
  const Vec2 center = begin + Vec2(b.y() * a.squaredNorm() - a.y() * b.squaredNorm(),
                                   a.x() * b.squaredNorm() - b.x() * a.squaredNorm()) /
                                  turn;
  return MakeArcBetween(begin, end, center, turn > 0);
}

Result<Vec2> KicadPoint(const SExpression& in, std::string_view name) {
  const auto list = in.Find(name);
  if (!list) return WrongExpression(in, name);
  return PointOf(*list);
}

Result<KicadPlace> KicadAt(const SExpression& in) {
  const Vec2 at = INTAGLIO_TRY(KicadPoint(in, "at"));
  const double degrees = in.Find("at")->Number(3).value_or(0);
  if (std::abs(degrees) > 3600) return WrongExpression(in, "at");
  return KicadPlace{{at.x(), -at.y()}, degrees * pi / 180};
}

Result<double> KicadNumber(const SExpression& in, std::string_view name,
                           double otherwise) {
  const auto list = in.Find(name);
  if (!list) return otherwise;
  const auto number = list->Number(1);
  if (!number || std::abs(*number) > kMaxKicadPlace_mm) return WrongExpression(in, name);
  return *number;
}

Result<std::vector<Vec2>> KicadCorners(const SExpression& in, const KicadPlace& place) {
  const auto list = in.Find("pts");
  std::vector<Vec2> corners;
  if (list) {
    for (const SExpression& item : list->items()) {
      if (!item.is_list()) continue;
      if (item.name() != "xy")
        return Fail(ErrorCode::kUnsupported,
                    "arcs in polygons are not read; draw the polygon with lines");
      corners.push_back(place.Of(INTAGLIO_TRY(PointOf(item))));
    }
  }
  if (corners.size() < 3)
    return Fail(ErrorCode::kInvalidValue, "a polygon has fewer than three corners");
  return corners;
}

Result<std::optional<KicadGraphic>> GraphicOf(const SExpression& item,
                                              const KicadPlace& place) {
  const std::string_view name = item.name();
  const std::string_view kind = name.substr(name.find('_') + 1);
  if (!(name.starts_with("gr_") || name.starts_with("fp_")) ||
      (kind != "line" && kind != "arc" && kind != "circle" && kind != "rect" &&
       kind != "poly"))
    return std::optional<KicadGraphic>();
  KicadGraphic graphic;
  graphic.edges = INTAGLIO_TRY(EdgesOfGraphic(item, kind, place));
  graphic.closed = kind == "circle" || kind == "rect" || kind == "poly";
  const auto stroke = item.Find("stroke");
  graphic.width_mm = INTAGLIO_TRY(KicadNumber(stroke ? *stroke : item, "width", 0));
  // Without a word polygons are filled, as before version 6.
  const auto fill = item.Find("fill");
  graphic.filled =
      graphic.closed &&
      (fill ? fill->Text(1) == "solid" || fill->Text(1) == "yes" : kind == "poly");
  return std::optional(std::move(graphic));
}

std::vector<Shape> ShapesOf(const KicadGraphic& graphic) {
  std::vector<Shape> shapes;
  if (graphic.filled) {
    const Edge& first = graphic.edges.front();
    if (graphic.edges.size() == 1)
      return {
          Circle{first.center_mm, 2 * first.radius_mm + std::max(graphic.width_mm, 0.0)}};
    shapes.push_back(Outline{{graphic.edges}});
  }
  if (graphic.width_mm <= 0) return shapes;
  for (const Edge& edge : graphic.edges) {
    if (edge.is_arc())
      shapes.push_back(ArcTrack{edge, graphic.width_mm});
    else
      shapes.push_back(Track{edge.begin_mm, edge.end_mm, graphic.width_mm});
  }
  return shapes;
}

namespace {

Status AppendPrimitives(const SExpression& pad, const KicadPlace& place,
                        std::vector<Shape>& shapes, std::vector<std::string>& left_out) {
  const auto primitives = pad.Find("primitives");
  if (!primitives) return {};
  for (const SExpression& item : primitives->items()) {
    if (!item.is_list()) continue;
    const auto graphic = INTAGLIO_TRY(GraphicOf(item, place));
    if (!graphic) {
      left_out.push_back(std::string(item.name()));
      continue;
    }
    for (Shape& shape : ShapesOf(*graphic)) shapes.push_back(std::move(shape));
  }
  return {};
}

}  // namespace

Result<std::vector<Shape>> PadShapes(const SExpression& pad, const KicadPlace& pad_place,
                                     std::vector<std::string>& left_out) {
  const std::string kind = pad.Text(3);
  const Vec2 sides = INTAGLIO_TRY(KicadPoint(pad, "size"));
  if (!(sides.minCoeff() > 0))
    return Fail(ErrorCode::kInvalidValue, "the size of a pad is not positive");
  KicadPlace place = pad_place;
  const auto drill = pad.Find("drill");
  if (drill && drill->Find("offset"))
    place.at_mm = place.Of(INTAGLIO_TRY(KicadPoint(*drill, "offset")));
  if (pad.Find("chamfer_ratio")) left_out.emplace_back("chamfered corners of a pad");
  double radius = 0;
  if (kind == "circle") return std::vector<Shape>{Circle{place.at_mm, sides.x()}};
  if (kind == "oval") {
    radius = sides.minCoeff() / 2;
  } else if (kind == "roundrect") {
    const double ratio = INTAGLIO_TRY(KicadNumber(pad, "roundrect_rratio", 0.25));
    radius = std::clamp(ratio, 0.0, 0.5) * sides.minCoeff();
  } else if (kind == "custom") {
    const auto options = pad.Find("options");
    const auto anchor = options ? options->Find("anchor") : std::nullopt;
    if (!anchor || anchor->Text(1) != "rect") radius = sides.minCoeff() / 2;
  } else if (kind == "trapezoid") {
    left_out.emplace_back("slanted sides of a pad");
  } else if (kind != "rect") {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("pads of the shape '{}' are not read", kind));
  }
  std::vector<Shape> shapes{RoundBox(place.at_mm, sides, radius, place.turned_rad)};
  if (kind == "custom") INTAGLIO_TRY(AppendPrimitives(pad, pad_place, shapes, left_out));
  return shapes;
}

}  // namespace intaglio::contour
