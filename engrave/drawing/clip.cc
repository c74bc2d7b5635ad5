// Every shape becomes loops with its inside to their left, and all of these together the
// loops of the clip, each by the winding numbers that are wanted. A point is then within
// the clip when an odd number of edges lies to one side of it, which a tree of boxes
// counts. The area of a curve runs around a point within the clip as often as the curve
// does, and around no other.

#include "engrave/drawing/clip.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "engrave/contour/crossings.h"
#include "engrave/contour/region/winding_loops.h"
#include "engrave/drawing/flatten.h"
#include "engrave/drawing/pieces.h"

namespace intaglio::drawing {
namespace {

using contour::Edge;
using contour::Edges;
using contour::EdgeTree;
using contour::FlatBox;

// Two outlines that are flattened to 1 um each are one border.
constexpr double kBorder_mm = 2e-3;
// Corners of areas nearer to each other are one.
constexpr double kCorner_mm = 2e-5;
// Farther away curves are not drawn: their readers refuse them.
constexpr double kMaxCoordinate_mm = 1e9;
// Where edges nearly touch corners are moved by so little, and then by more.
constexpr double kMoves_mm[] = {0, 8e-5, 2e-4};

bool IsWithinReach(const Curve& curve) {
  return std::ranges::all_of(curve.pieces, [](const Piece& piece) {
    return WithinReach(piece, kMaxCoordinate_mm);
  });
}

/// -1 .. 1, the same for the same place and different for its neighbours.
double Noise(const Vec2& place, double salt) {
  std::uint64_t bits = 0;
  for (const double number : {place.x(), place.y(), salt}) {
    bits = (bits ^ std::bit_cast<std::uint64_t>(number)) * 0x9E3779B97F4A7C15U;
    bits ^= bits >> 29;
  }
  return static_cast<double>(bits >> 11) / 0x1p52 - 1;
}

/// The edges of a closed polygon, each corner moved by at most so much in x and y; none
/// when it has no inside.
Edges EdgesOf(const PointList& points, double moved_mm) {
  std::vector<Vec2> corners;
  for (const Vec3& p : points) {
    if (corners.empty() || (p.head<2>() - corners.back()).norm() > kCorner_mm)
      corners.emplace_back(p.head<2>());
  }
  while (corners.size() > 1 && (corners.front() - corners.back()).norm() <= kCorner_mm)
    corners.pop_back();
  Edges edges;
  if (corners.size() < 3) return edges;
  for (Vec2& corner : corners)
    corner += moved_mm * Vec2(Noise(corner, 1), Noise(corner, 2));
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Edge edge = contour::MakeLine(corners[i], corners[(i + 1) % corners.size()]);
    if (edge.length_mm > kCorner_mm / 2) edges.push_back(edge);
  }
  return edges;
}

FlatBox BoxOf(const PointList& points, double margin_mm) {
  FlatBox box{points.front().head<2>(), points.front().head<2>()};
  for (const Vec3& p : points) {
    box.min_mm = box.min_mm.cwiseMin(p.head<2>());
    box.max_mm = box.max_mm.cwiseMax(p.head<2>());
  }
  const Vec2 margin = Vec2::Constant(margin_mm);
  return {box.min_mm - margin, box.max_mm + margin};
}

/// Of the same sign and parity, so that every rule finds the same inside: a curve that
/// runs a thousand times around makes no thousand loops.
int Bounded(int winding) {
  if (winding > 2) return 2 - winding % 2;
  if (winding < -2) return -2 - winding % 2;
  return winding;
}

bool Count(std::uint64_t pairs, ClipWork& work) {
  const bool enough = pairs < work.pairs_left;
  work.pairs_left -= std::min(pairs, work.pairs_left);
  return enough;
}

Curve CurveLike(const Curve& model, PointList points, bool closed) {
  return {{Polyline{std::move(points)}}, closed, model.layer, model.color};
}

PointList PointsOf(const Edges& loop, double z_mm) {
  PointList points;
  for (const Edge& edge : loop)
    points.emplace_back(edge.begin_mm.x(), edge.begin_mm.y(), z_mm);
  return points;
}

double LengthOf(const PointList& line) {
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
  return length;
}

Edges AllOf(const std::vector<Edges>& loops) {
  Edges edges;
  for (const Edges& loop : loops) edges.insert(edges.end(), loop.begin(), loop.end());
  return edges;
}

std::vector<PointList> PolygonsOf(const std::vector<Edges>& loops) {
  std::vector<PointList> polygons;
  for (const Edges& loop : loops) polygons.push_back(PointsOf(loop, 0));
  return polygons;
}

/// The loops around what `wanted` takes for the inside of polygons by the winding number.
template <typename Wanted>
std::optional<std::vector<Edges>> LoopsBy(const std::vector<PointList>& polygons,
                                          const Wanted& wanted, ClipWork& work) {
  for (const double moved_mm : kMoves_mm) {
    Edges edges;
    for (const PointList& polygon : polygons) {
      const Edges next = EdgesOf(polygon, moved_mm);
      edges.insert(edges.end(), next.begin(), next.end());
    }
    if (edges.empty()) return std::vector<Edges>();
    const EdgeTree tree(edges);
    auto loops = contour::LoopsOfWinding(
        edges, [&](const Vec2& p) { return wanted(tree.Winding(p)) ? 1 : 0; },
        work.pairs_left);
    if (loops) return std::move(*loops);
  }
  return std::nullopt;
}

}  // namespace

ClipArea::ClipArea(std::vector<Edges> loops)
    : loops_(std::move(loops)), edges_(AllOf(loops_)) {
  if (!edges_.empty()) tree_.emplace(edges_);
}

std::optional<ClipArea> ClipArea::OfShapes(const std::vector<ClipShape>& shapes,
                                           ClipWork& work) {
  if (work.pairs_left == 0) return std::nullopt;
  std::vector<Edges> loops;
  for (const ClipShape& shape : shapes) {
    std::vector<PointList> polygons;
    for (const Curve& curve : shape.outlines) {
      if (!IsWithinReach(curve)) return std::nullopt;
      if (auto flat = FlattenCurve(curve)) polygons.push_back(std::move(flat->points_mm));
    }
    auto inside = LoopsBy(
        polygons,
        [&](int winding) { return shape.even_odd ? winding % 2 != 0 : winding != 0; },
        work);
    if (!inside) return std::nullopt;
    for (Edges& loop : *inside) loops.push_back(std::move(loop));
  }
  if (shapes.size() < 2) return ClipArea(std::move(loops));
  auto united = LoopsBy(
      PolygonsOf(loops), [](int winding) { return winding > 0; }, work);
  if (!united) return std::nullopt;
  return ClipArea(std::move(*united));
}

std::optional<ClipArea> ClipArea::OfBoth(const ClipArea& a, const ClipArea& b,
                                         ClipWork& work) {
  if (work.pairs_left == 0) return std::nullopt;
  std::vector<PointList> polygons = PolygonsOf(a.loops_);
  for (PointList& polygon : PolygonsOf(b.loops_)) polygons.push_back(std::move(polygon));
  auto loops = LoopsBy(
      polygons, [](int winding) { return winding > 1; }, work);
  if (!loops) return std::nullopt;
  return ClipArea(std::move(*loops));
}

ClipShape ClipArea::AsShape() const {
  ClipShape shape;
  for (PointList& polygon : PolygonsOf(loops_))
    shape.outlines.push_back(CurveLike({}, std::move(polygon), true));
  return shape;
}

bool ClipArea::IsInside(const Vec2& point_mm) const {
  return tree_ && tree_->IsInside(point_mm);
}

bool ClipArea::IsWithin(const Vec2& point_mm) const {
  return IsInside(point_mm) || (tree_ && tree_->DistanceTo(point_mm) <= kBorder_mm);
}

/// The shares of a line at which it may come into or out of the area: where it crosses
/// edges, and beside their ends on the border; with 0 and 1, ascending. Empty: too much.
std::vector<double> ClipArea::CutsOf(const Vec3& from, const Vec3& to,
                                     ClipWork& work) const {
  std::vector<double> cuts{0, 1};
  const Edge line = contour::MakeLine(from.head<2>(), to.head<2>());
  if (line.length_mm == 0 || !tree_) return cuts;
  const auto near = tree_->EdgesIn(BoxOf({from, to}, 2 * kBorder_mm));
  if (!Count(near.size() + 1, work)) return {};
  std::vector<Vec2> points;
  for (const std::uint32_t k : near) {
    contour::AppendCrossings(line, edges_[k], points);
    if (contour::DistanceTo(line, edges_[k].begin_mm) <= 2 * kBorder_mm)
      points.push_back(edges_[k].begin_mm);
  }
  for (const Vec2& point : points) {
    const double share = contour::WayTo(line, point) / line.length_mm;
    if (share > 0 && share < 1) cuts.push_back(share);
  }
  std::ranges::sort(cuts);
  return cuts;
}

ClipArea::Lines ClipArea::LinesWithin(const PointList& points, bool closed,
                                      ClipWork& work) const {
  Lines within;
  PointList open;
  const auto end_line = [&] {
    within.whole = false;
    if (!open.empty()) within.lines.push_back(std::exchange(open, {}));
  };
  const std::size_t count = closed ? points.size() : points.size() - 1;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3& p = points[i];
    const Vec3& q = points[(i + 1) % points.size()];
    const std::vector<double> cuts = CutsOf(p, q, work);
    if (cuts.empty()) return {{}, false, true};
    std::vector<char> is_within;
    for (std::size_t c = 0; c + 1 < cuts.size(); ++c) {
      const Vec3 middle = p + 0.5 * (cuts[c] + cuts[c + 1]) * (q - p);
      is_within.push_back(IsWithin(middle.head<2>()));
    }
    for (std::size_t c = 0; c < is_within.size(); ++c) {
      if (!is_within[c]) {
        end_line();
        continue;
      }
      if (open.empty()) open.emplace_back(p + cuts[c] * (q - p));
      // Corners stay, cuts between two parts that are both within do not.
      if (c + 1 == is_within.size()) {
        open.push_back(q);
      } else if (!is_within[c + 1]) {
        open.emplace_back(p + cuts[c + 1] * (q - p));
      }
    }
  }
  // A closed line that is cut goes on over its beginning.
  if (closed && !open.empty() && !within.lines.empty() &&
      within.lines.front().front() == points.front()) {
    const PointList& first = within.lines.front();
    open.insert(open.end(), first.begin() + 1, first.end());
    within.lines.erase(within.lines.begin());
  }
  if (!open.empty()) within.lines.push_back(std::move(open));
  return within;
}

/// Whether an edge of the area is in the polygon, and not on its outline alone.
bool ClipArea::ReachesInto(const EdgeTree& polygon,
                           const std::vector<std::uint32_t>& edges) const {
  return std::ranges::any_of(edges, [&](std::uint32_t k) {
    const Vec2 middle = 0.5 * (edges_[k].begin_mm + edges_[k].end_mm);
    return polygon.Winding(middle) != 0 && polygon.DistanceTo(middle) > kBorder_mm;
  });
}

bool ClipArea::CutFilled(const Curve& curve, const PointList& points,
                         const std::vector<std::uint32_t>& near, ClipWork& work,
                         std::vector<Curve>& inside) const {
  const Lines within = LinesWithin(points, true, work);
  if (within.too_much) return false;
  if (within.whole && !ReachesInto(EdgeTree(EdgesOf(points, 0)), near)) {
    inside.push_back(curve);
    return true;
  }
  const double z_mm = points.front().z();
  const bool level = std::ranges::all_of(
      points, [&](const Vec3& p) { return std::abs(p.z() - z_mm) <= kCorner_mm; });
  for (const double moved_mm : kMoves_mm) {
    if (!level) break;
    Edges edges = EdgesOf(points, moved_mm);
    if (edges.empty()) continue;
    const EdgeTree polygon(edges);
    for (const std::uint32_t k : near) edges.push_back(edges_[k]);
    const auto loops = contour::LoopsOfWinding(
        edges,
        [&](const Vec2& p) { return IsInside(p) ? Bounded(polygon.Winding(p)) : 0; },
        work.pairs_left);
    if (!loops) continue;
    for (const Edges& loop : *loops)
      inside.push_back(CurveLike(curve, PointsOf(loop, z_mm), true));
    return true;
  }
  return false;
}

bool ClipArea::Cut(const Curve& curve, bool filled, ClipWork& work,
                   std::vector<Curve>& inside) const {
  if (!IsWithinReach(curve)) return false;
  const auto flat = FlattenCurve(curve);
  if (!flat) return true;
  const PointList& points = flat->points_mm;
  if (!Count(points.size(), work)) return false;
  const auto near =
      tree_ ? tree_->EdgesIn(BoxOf(points, kBorder_mm)) : std::vector<std::uint32_t>();
  if (near.empty() || points.size() == 1) {
    if (IsWithin(points.front().head<2>())) inside.push_back(curve);
    return true;
  }
  if (!Count(near.size(), work)) return false;
  if (filled && !EdgesOf(points, 0).empty())
    return CutFilled(curve, points, near, work, inside);
  Lines within = LinesWithin(points, flat->closed, work);
  if (within.too_much) return false;
  if (within.whole) inside.push_back(curve);
  if (within.whole) return true;
  for (PointList& line : within.lines) {
    if (LengthOf(line) > kBorder_mm)
      inside.push_back(CurveLike(curve, std::move(line), false));
  }
  return true;
}

}  // namespace intaglio::drawing
