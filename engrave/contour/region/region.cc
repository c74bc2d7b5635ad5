#include "engrave/contour/region/region.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "engrave/contour/region/region_index.h"
#include "engrave/contour/simple_loops.h"
#include "engrave/core/try.h"

namespace intaglio::contour {
namespace {

constexpr double kMinDistance_mm = 0.0005;
constexpr double kMaxDistance_mm = 5000;

/// What a disc of this diameter sweeps along an edge.
Element SweptElement(const Edge& edge, double diameter_mm) {
  if (edge.is_arc()) return {ArcTrack{edge, diameter_mm}, {}};
  return {Track{edge.begin_mm, edge.end_mm, diameter_mm}, {}};
}

Result<Union> SweptBorder(std::span<const Edges> paths, double diameter_mm) {
  if (!(diameter_mm >= 2 * kMinDistance_mm && diameter_mm <= 2 * kMaxDistance_mm))
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("a distance of {} mm is not within {} .. {} mm; correct it",
                            diameter_mm / 2, kMinDistance_mm, kMaxDistance_mm),
                fmt::format("{}", diameter_mm / 2));
  std::vector<Element> elements;
  for (const Edges& path : paths) {
    for (const Edge& edge : path) elements.push_back(SweptElement(edge, diameter_mm));
  }
  return Unite(elements, {0, Corners::kRound});
}

Edges Turned(const Edges& loop) {
  Edges turned;
  for (auto edge = loop.rbegin(); edge != loop.rend(); ++edge)
    turned.push_back(Reversed(*edge));
  return turned;
}

/// The contours of the swept border lie at the distance from it, wholly on one side.
Result<Region> Offset(const Region& region, double distance_mm, bool inside) {
  const Union border = INTAGLIO_TRY(SweptBorder(region.loops, 2 * distance_mm));
  const RegionIndex index(region);
  Region offset;
  for (const Contour& contour : border.contours) {
    const Edge& edge = contour.edges.front();
    if (index.IsInside(PointAt(edge, edge.length_mm / 2)) == inside)
      offset.loops.push_back(inside ? Turned(contour.edges) : contour.edges);
  }
  return offset;
}

}  // namespace

EdgeBox BoxOfEdge(const Edge& edge) {
  EdgeBox box{edge.begin_mm.cwiseMin(edge.end_mm), edge.begin_mm.cwiseMax(edge.end_mm)};
  if (!edge.is_arc()) return box;
  const Vec2 middle = PointAt(edge, edge.length_mm / 2);
  const Vec2 reach =
      Vec2::Constant(2 * edge.radius_mm * std::sin(std::abs(edge.sweep_rad) / 4));
  // Neither the circle nor the points that far from the arc's middle are left.
  const Vec2 radius = Vec2::Constant(edge.radius_mm);
  box.min_mm = box.min_mm.cwiseMin((middle - reach).cwiseMax(edge.center_mm - radius));
  box.max_mm = box.max_mm.cwiseMax((middle + reach).cwiseMin(edge.center_mm + radius));
  return box;
}

EdgeBox BoxOfEdges(const Edges& edges) {
  EdgeBox box = BoxOfEdge(edges.front());
  for (const Edge& edge : edges) {
    const EdgeBox next = BoxOfEdge(edge);
    box = {box.min_mm.cwiseMin(next.min_mm), box.max_mm.cwiseMax(next.max_mm)};
  }
  return box;
}

EdgeBox BoxOfRegion(const Region& region) {
  EdgeBox box = BoxOfEdges(region.loops.front());
  for (const Edges& loop : region.loops) {
    const EdgeBox next = BoxOfEdges(loop);
    box = {box.min_mm.cwiseMin(next.min_mm), box.max_mm.cwiseMax(next.max_mm)};
  }
  return box;
}

RegionIndex::RegionIndex(const Region& region) {
  for (const Edges& loop : region.loops) {
    edges_.insert(edges_.end(), loop.begin(), loop.end());
    area_mm2_ += AreaOf(loop);
  }
  if (!edges_.empty()) tree_.emplace(edges_);
}

Region RegionOf(const Union& drawn) {
  Region region;
  for (const Contour& contour : drawn.contours) region.loops.push_back(contour.edges);
  return region;
}

Result<Region> RegionOfLoops(const std::vector<Edges>& loops) {
  return Region{INTAGLIO_TRY(OrientedLoops(loops))};
}

double AreaOf(const Region& region) {
  double area = 0;
  for (const Edges& loop : region.loops) area += AreaOf(loop);
  return area;
}

bool IsInside(const Region& region, const Vec2& point_mm) {
  bool inside = false;
  for (const Edges& loop : region.loops) inside ^= IsInLoops(loop, point_mm);
  return inside;
}

Result<Region> Inset(const Region& region, double distance_mm) {
  return Offset(region, distance_mm, true);
}

Result<Region> Outset(const Region& region, double distance_mm) {
  return Offset(region, distance_mm, false);
}

Result<Region> Swept(std::span<const Edges> paths, double tool_diameter_mm) {
  return RegionOf(INTAGLIO_TRY(SweptBorder(paths, tool_diameter_mm)));
}

std::vector<Region> ConnectedParts(const Region& region) {
  struct Outer {
    std::size_t loop;
    double area;
    EdgeBox box;
  };
  std::vector<Outer> outers;
  std::vector<Region> parts;
  for (std::size_t k = 0; k < region.loops.size(); ++k) {
    const double area = AreaOf(region.loops[k]);
    if (area <= 0) continue;
    outers.push_back({k, area, BoxOfEdges(region.loops[k])});
    parts.push_back({{region.loops[k]}});
  }
  // A hole belongs to the smallest outer loop around it.
  for (const Edges& loop : region.loops) {
    const double area = AreaOf(loop);
    if (area > 0) continue;
    const Vec2 place = PointAt(loop.front(), loop.front().length_mm / 2);
    std::optional<std::size_t> smallest;
    for (std::size_t k = 0; k < outers.size(); ++k) {
      const auto& [outer, outer_area, box] = outers[k];
      if (outer_area < -area || (smallest && outer_area >= outers[*smallest].area) ||
          (place.array() < box.min_mm.array()).any() ||
          (place.array() > box.max_mm.array()).any())
        continue;
      if (IsInLoops(region.loops[outer], place)) smallest = k;
    }
    if (smallest) parts[*smallest].loops.push_back(loop);
  }
  return parts;
}

}  // namespace intaglio::contour
