#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engrave/contour/area.h"
#include "engrave/contour/crossings.h"
#include "engrave/contour/near_pairs.h"
#include "engrave/contour/simple_loops.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;
constexpr double kMinSize_mm = 1e-3;

std::vector<Vec2> SquareCorners(const Vec2& c, double half) {
  return {c + Vec2(-half, -half), c + Vec2(half, -half), c + Vec2(half, half),
          c + Vec2(-half, half)};
}

/// The corners of a regular octagon lie half a side, half * tan(pi / 8), off its axes.
std::vector<Vec2> OctagonCorners(const Vec2& c, double half) {
  const double k = half * std::tan(pi / 8);
  return {c + Vec2(-k, -half), c + Vec2(k, -half), c + Vec2(half, -k),
          c + Vec2(half, k),   c + Vec2(k, half),  c + Vec2(-k, half),
          c + Vec2(-half, k),  c + Vec2(-half, -k)};
}

/// What the tool sweeps along an arc, without the round ends: a sector of a ring, or of
/// the disc where the ring has no hole.
Area SectorArea(Edge arc, double half_width) {
  if (arc.sweep_rad < 0) arc = Reversed(arc);
  const double outer = arc.radius_mm + half_width;
  const double inner = arc.radius_mm - half_width;
  const bool hole = inner > kVertex_mm;
  const bool full = arc.sweep_rad >= 2 * pi;
  const Edge outside = MakeArc(arc.center_mm, outer, arc.begin_rad, arc.sweep_rad);
  std::vector<Edges> loops{{outside}};
  if (hole) {
    const Edge inside =
        Reversed(MakeArc(arc.center_mm, inner, arc.begin_rad, arc.sweep_rad));
    if (full) {
      loops.push_back({inside});
    } else {
      loops[0].push_back(MakeLine(outside.end_mm, inside.begin_mm));
      loops[0].push_back(inside);
      loops[0].push_back(MakeLine(inside.end_mm, outside.begin_mm));
    }
  } else if (!full) {
    loops[0].push_back(MakeLine(outside.end_mm, arc.center_mm));
    loops[0].push_back(MakeLine(arc.center_mm, outside.begin_mm));
  }
  return LoopArea(loops);
}

bool IsConvexPolygon(const std::vector<Edges>& loops) {
  if (loops.size() != 1 || loops[0].size() < 3) return false;
  const Edges& loop = loops[0];
  double turned = 0;
  for (std::size_t k = 0; k < loop.size(); ++k) {
    const Edge& a = loop[k];
    const Edge& b = loop[(k + 1) % loop.size()];
    if (a.is_arc()) return false;
    const Vec2 in = a.end_mm - a.begin_mm;
    const Vec2 out = b.end_mm - b.begin_mm;
    const double turn = std::atan2(Cross(in, out), in.dot(out));
    if (turn < 1e-9) return false;
    turned += turn;
  }
  return std::abs(turned - 2 * pi) < 1e-6;
}

class Growing {
 public:
  Growing(const Element& element, double radius, Corners corners)
      : element_(element), radius_(radius), corners_(corners) {}

  Result<std::vector<Area>> operator()(const Circle& s) const {
    return Disc(s.center_mm, s.diameter_mm);
  }
  Result<std::vector<Area>> operator()(const Square& s) const {
    const double half = s.side_mm / 2;
    return corners_ == Corners::kSharp
               ? Polygon(SquareCorners(s.center_mm, half + radius_), 0, s.side_mm)
               : Polygon(SquareCorners(s.center_mm, half), radius_, s.side_mm);
  }
  Result<std::vector<Area>> operator()(const Octagon& s) const {
    const double half = s.size_mm / 2;
    return corners_ == Corners::kSharp
               ? Polygon(OctagonCorners(s.center_mm, half + radius_), 0, s.size_mm)
               : Polygon(OctagonCorners(s.center_mm, half), radius_, s.size_mm);
  }
  Result<std::vector<Area>> operator()(const Track& s) const {
    if (s.begin_mm == s.end_mm) return Disc(s.begin_mm, s.width_mm);
    if (s.width_mm + 2 * radius_ < kMinSize_mm) return TooThin();
    return One(ConvexArea({s.begin_mm, s.end_mm}, s.width_mm / 2 + radius_));
  }
  Result<std::vector<Area>> operator()(const ArcTrack& s) const {
    const double half = s.width_mm / 2 + radius_;
    if (2 * half < kMinSize_mm) return TooThin();
    std::vector<Area> areas;
    AppendSweptArc(s.arc, half, areas);
    return areas;
  }
  Result<std::vector<Area>> operator()(const Outline& s) const {
    std::vector<Edges> loops = INTAGLIO_TRY(OrientedLoops(s.loops));
    if (IsConvexPolygon(loops)) {
      std::vector<Vec2> core;
      for (const Edge& edge : loops[0]) core.push_back(edge.begin_mm);
      return One(ConvexArea(std::move(core), radius_));
    }
    std::vector<Area> areas{LoopArea(loops)};
    if (radius_ == 0) return areas;
    for (const Edges& loop : loops) {
      for (const Edge& edge : loop) {
        if (edge.is_arc())
          AppendSweptArc(edge, radius_, areas);
        else
          areas.push_back(ConvexArea({edge.begin_mm, edge.end_mm}, radius_));
      }
    }
    return areas;
  }

 private:
  static std::vector<Area> One(Area area) {
    std::vector<Area> areas;
    areas.push_back(std::move(area));
    return areas;
  }
  tl::unexpected<Error> TooThin() const {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("{} is thinner than {} mm with the tool's radius of {} mm; "
                            "give it a size or choose a tool",
                            Describe(element_), kMinSize_mm, radius_));
  }
  Result<std::vector<Area>> Disc(const Vec2& center, double diameter) const {
    if (diameter + 2 * radius_ < kMinSize_mm) return TooThin();
    return One(ConvexArea({center}, diameter / 2 + radius_));
  }
  Result<std::vector<Area>> Polygon(std::vector<Vec2> core, double margin,
                                    double size) const {
    if (size < kMinSize_mm) return TooThin();
    return One(ConvexArea(std::move(core), margin));
  }
  static void AppendSweptArc(const Edge& arc, double half, std::vector<Area>& areas) {
    areas.push_back(SectorArea(arc, half));
    if (std::abs(arc.sweep_rad) >= 2 * pi) return;
    areas.push_back(ConvexArea({arc.begin_mm}, half));
    areas.push_back(ConvexArea({arc.end_mm}, half));
  }

  const Element& element_;
  double radius_;
  Corners corners_;
};

}  // namespace

Status AppendGrown(const Element& element, std::uint32_t number, double radius_mm,
                   Corners corners, std::vector<Area>& areas) {
  auto grown = std::visit(Growing(element, radius_mm, corners), element.shape);
  if (!grown) {
    Error error = std::move(grown).error();
    if (!std::holds_alternative<Outline>(element.shape)) return tl::unexpected(error);
    error.message = Describe(element) + " " + error.message;
    return tl::unexpected(std::move(error));
  }
  for (Area& area : *grown) {
    area.element = number;
    areas.push_back(std::move(area));
  }
  return {};
}

}  // namespace intaglio::contour
