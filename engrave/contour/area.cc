#include "engrave/contour/area.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "engrave/contour/simple_loops.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;
// Below it a tree costs more than it saves.
constexpr std::size_t kEdgesForTree = 32;

double DepthOfPolygon(const Area& area, const Vec2& p) {
  const std::size_t count = area.core_mm.size();
  double inside = -std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < count; ++k) {
    const Vec2& a = area.core_mm[k];
    const Vec2 side = area.core_mm[k + 1 == count ? 0 : k + 1] - a;
    inside = std::max(inside, Cross(p - a, side) / side.norm());
  }
  if (area.margin_mm == 0 || inside <= 0) return inside - area.margin_mm;
  double squared = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < count; ++k) {
    const Vec2& a = area.core_mm[k];
    const Vec2 side = area.core_mm[k + 1 == count ? 0 : k + 1] - a;
    const double t = std::clamp((p - a).dot(side) / side.squaredNorm(), 0.0, 1.0);
    squared = std::min(squared, (p - a - t * side).squaredNorm());
  }
  return std::sqrt(squared) - area.margin_mm;
}

double DepthOfLoops(const Area& area, const Vec2& p) {
  if (area.tree) {
    const double distance = area.tree->DistanceTo(p);
    return area.tree->IsInside(p) ? -distance : distance;
  }
  double nearest = std::numeric_limits<double>::infinity();
  for (const Edge& edge : area.edges) nearest = std::min(nearest, DistanceTo(edge, p));
  return IsInLoops(area.edges, p) ? -nearest : nearest;
}

void Finish(Area& area) {
  area.min_mm = Vec2::Constant(std::numeric_limits<double>::infinity());
  area.max_mm = -area.min_mm;
  const auto extend = [&](const Vec2& p, double by) {
    area.min_mm = area.min_mm.cwiseMin(p - Vec2::Constant(by));
    area.max_mm = area.max_mm.cwiseMax(p + Vec2::Constant(by));
  };
  for (const Vec2& p : area.core_mm) extend(p, area.margin_mm);
  for (const Edge& edge : area.edges) {
    const Vec2 middle = PointAt(edge, edge.length_mm / 2);
    const double reach = edge.is_arc()
                             ? 2 * edge.radius_mm * std::sin(std::abs(edge.sweep_rad) / 4)
                             : edge.length_mm / 2;
    area.middles.push_back({middle, reach});
    if (!area.core_mm.empty()) continue;
    extend(edge.begin_mm, 0);
    extend(edge.end_mm, 0);
    if (edge.is_arc()) extend(middle, reach);
  }
}

Edges EdgesOfConvex(const std::vector<Vec2>& core, double margin) {
  if (core.size() == 1) return {MakeArc(core[0], margin, 0, 2 * pi)};
  Edges edges;
  for (std::size_t k = 0; k < core.size(); ++k) {
    const Vec2& a = core[k];
    const Vec2& b = core[(k + 1) % core.size()];
    const Vec2& c = core[(k + 2) % core.size()];
    const Vec2 out = margin * RightOf((b - a).normalized());
    edges.push_back(MakeLine(a + out, b + out));
    if (margin == 0) continue;
    const double begin = std::atan2(out.y(), out.x());
    const double turn =
        core.size() == 2 ? pi : std::atan2(Cross(b - a, c - b), (b - a).dot(c - b));
    if (turn <= 0) continue;  // three points on one line
    edges.push_back(MakeArc(b, margin, begin, turn));
    edges.back().begin_mm = b + out;
    edges.back().end_mm = b + margin * RightOf((c - b).normalized());
  }
  return edges;
}

}  // namespace

double Depth(const Area& area, const Vec2& p) {
  switch (area.core_mm.size()) {
    case 0:
      return DepthOfLoops(area, p);
    case 1:
      return (p - area.core_mm[0]).norm() - area.margin_mm;
    case 2: {
      const Vec2 along = area.core_mm[1] - area.core_mm[0];
      const Vec2 from = p - area.core_mm[0];
      const double t = std::clamp(from.dot(along) / along.squaredNorm(), 0.0, 1.0);
      return (from - t * along).norm() - area.margin_mm;
    }
    default:
      return DepthOfPolygon(area, p);
  }
}

Area ConvexArea(std::vector<Vec2> core_mm, double margin_mm) {
  Area area;
  area.edges = EdgesOfConvex(core_mm, margin_mm);
  area.core_mm = std::move(core_mm);
  area.margin_mm = margin_mm;
  Finish(area);
  return area;
}

Area LoopArea(const std::vector<Edges>& loops) {
  Area area;
  for (const Edges& loop : loops) {
    area.edges.insert(area.edges.end(), loop.begin(), loop.end());
  }
  Finish(area);
  if (area.edges.size() >= kEdgesForTree)
    area.tree = std::make_shared<const EdgeTree>(area.edges);
  return area;
}

std::vector<std::uint32_t> EdgesNear(const Area& area, const FlatBox& box_mm) {
  if (area.tree) return area.tree->EdgesIn(box_mm);
  std::vector<std::uint32_t> all(area.edges.size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

}  // namespace intaglio::contour
