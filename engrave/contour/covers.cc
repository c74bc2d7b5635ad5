#include "engrave/contour/covers.h"

#include <algorithm>
#include <cmath>

namespace intaglio::contour {
namespace {

constexpr double kSlack_mm = 1e-5;

bool IsNear(const Edge& edge, const Vec2& point) {
  const double off =
      edge.is_arc()
          ? (point - edge.center_mm).norm() - edge.radius_mm
          : Cross(edge.end_mm - edge.begin_mm, point - edge.begin_mm) / edge.length_mm;
  return std::abs(off) < kVertex_mm && DistanceTo(edge, point) < kVertex_mm;
}

}  // namespace

CoverFinder::CoverFinder(std::span<const Area> areas, double tolerance_mm)
    : areas_(areas), tolerance_mm_(tolerance_mm) {
  first_edge_.reserve(areas.size() + 1);
  first_edge_.push_back(0);
  for (const Area& area : areas) {
    first_edge_.push_back(first_edge_.back() +
                          static_cast<std::uint32_t>(area.edges.size()));
  }
}

/// A signed distance changes by no more than the way: one value at an edge's middle
/// decides for those that are wholly outside or inside.
void CoverFinder::Sort(Side& side, std::uint32_t other, std::vector<Cover>& covers) {
  const Area& area = areas_[side.area];
  side.count = 0;
  const auto sort = [&](std::uint32_t k) {
    const auto& [middle, reach] = area.middles[k];
    const double depth = Depth(areas_[other], middle);
    if (depth > reach + kSlack_mm) return;
    const Edge& edge = area.edges[k];
    if (depth < -reach - kSlack_mm) {
      touch_ = true;
      covers.push_back({first_edge_[side.area] + k, other, CoverKind::kInside, 0,
                        edge.length_mm, edge.begin_mm, edge.end_mm, depth});
      return;
    }
    if (side.divided.size() == side.count) side.divided.emplace_back();
    Divided& divided = side.divided[side.count++];
    divided.edge = k;
    divided.cuts.clear();
    divided.shared.clear();
  };
  if (!area.tree) {
    for (std::uint32_t k = 0; k < area.edges.size(); ++k) sort(k);
    return;
  }
  const Vec2 slack = Vec2::Constant(2 * kSlack_mm);
  const FlatBox near{areas_[other].min_mm - slack, areas_[other].max_mm + slack};
  for (const std::uint32_t k : EdgesNear(area, near)) sort(k);
}

void CoverFinder::Meet(Divided& a, Divided& b) {
  const Edge& edge_a = areas_[first_.area].edges[a.edge];
  const Edge& edge_b = areas_[second_.area].edges[b.edge];
  points_.clear();
  AppendCrossings(edge_a, edge_b, points_);
  // The other ends are beginnings of other edges.
  if (IsNear(edge_a, edge_b.begin_mm)) points_.push_back(edge_b.begin_mm);
  if (IsNear(edge_b, edge_a.begin_mm)) points_.push_back(edge_a.begin_mm);
  const auto cut = [](const Edge& edge, Divided& divided, const Vec2& point) {
    const double way = WayTo(edge, point);
    if (way > kVertex_mm && way < edge.length_mm - kVertex_mm)
      divided.cuts.push_back({way, point});
  };
  for (const Vec2& point : points_) {
    cut(edge_a, a, point);
    cut(edge_b, b, point);
    touch_ = true;
  }
  const std::size_t before = a.shared.size();
  AppendSharedParts(edge_a, edge_b, tolerance_mm_, a.shared);
  if (a.shared.size() == before) return;
  AppendSharedParts(edge_b, edge_a, tolerance_mm_, b.shared);
  touch_ = true;
}

void CoverFinder::AddCover(const Side& side, const Divided& divided, const Cut& begin,
                           const Cut& end, std::uint32_t other,
                           std::vector<Cover>& covers) {
  const double middle = 0.5 * (begin.way_mm + end.way_mm);
  Cover cover{first_edge_[side.area] + divided.edge,
              other,
              CoverKind::kInside,
              begin.way_mm,
              end.way_mm,
              begin.place_mm,
              end.place_mm,
              0};
  const auto runs_along = [&](const SharedPart& part) {
    return part.begin_mm <= middle && middle <= part.end_mm;
  };
  const auto shared =
      std::find_if(divided.shared.begin(), divided.shared.end(), runs_along);
  if (shared != divided.shared.end()) {
    cover.kind = shared->same_direction ? CoverKind::kSame : CoverKind::kOpposite;
  } else {
    const Edge& edge = areas_[side.area].edges[divided.edge];
    cover.depth_mm = Depth(areas_[other], PointAt(edge, middle));
    if (cover.depth_mm >= 0) return;
  }
  covers.push_back(cover);
  touch_ = true;
}

void CoverFinder::Classify(Side& side, std::uint32_t other, std::vector<Cover>& covers) {
  for (std::size_t k = 0; k < side.count; ++k) {
    Divided& divided = side.divided[k];
    const Edge& edge = areas_[side.area].edges[divided.edge];
    std::sort(divided.cuts.begin(), divided.cuts.end(),
              [](const Cut& a, const Cut& b) { return a.way_mm < b.way_mm; });
    Cut begin{0, edge.begin_mm};
    for (std::size_t c = 0; c <= divided.cuts.size(); ++c) {
      const Cut end =
          c < divided.cuts.size() ? divided.cuts[c] : Cut{edge.length_mm, edge.end_mm};
      if (end.way_mm - begin.way_mm <= kVertex_mm && c < divided.cuts.size()) continue;
      AddCover(side, divided, begin, end, other, covers);
      begin = end;
    }
  }
}

bool CoverFinder::Find(const Pair& pair, std::vector<Cover>& covers) {
  touch_ = false;
  first_.area = pair.first;
  second_.area = pair.second;
  Sort(first_, pair.second, covers);
  Sort(second_, pair.first, covers);
  for (std::size_t a = 0; a < first_.count; ++a) {
    for (std::size_t b = 0; b < second_.count; ++b) {
      Meet(first_.divided[a], second_.divided[b]);
    }
  }
  Classify(first_, pair.second, covers);
  Classify(second_, pair.first, covers);
  return touch_;
}

}  // namespace intaglio::contour
