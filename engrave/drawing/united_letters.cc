#include "engrave/drawing/united_letters.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "engrave/contour/crossings.h"
#include "engrave/contour/edge_tree.h"
#include "engrave/core/groups.h"
#include "engrave/drawing/clip.h"
#include "engrave/drawing/flatten.h"

namespace intaglio::drawing {
namespace {

using contour::Edge;
using contour::Edges;
using contour::EdgeTree;
using contour::FlatBox;

void Extend(const Vec3& p, FlatBox& box) {
  box.min_mm = box.min_mm.cwiseMin(p.head<2>());
  box.max_mm = box.max_mm.cwiseMax(p.head<2>());
}

/// A box around the control points: the curve lies within.
FlatBox BoxOf(const Curve& curve) {
  FlatBox box{Vec2::Constant(1e300), Vec2::Constant(-1e300)};
  for (const Piece& piece : curve.pieces) {
    if (const auto* line = std::get_if<Polyline>(&piece)) {
      for (const Vec3& p : line->points_mm) Extend(p, box);
    } else if (const auto* bezier = std::get_if<CubicBezier>(&piece)) {
      for (const Vec3& p : bezier->control_mm) Extend(p, box);
    }
  }
  return box;
}

bool Meet(const FlatBox& a, const FlatBox& b) {
  return (a.min_mm.array() <= b.max_mm.array()).all() &&
         (b.min_mm.array() <= a.max_mm.array()).all();
}

/// The edges of a closed curve; none when it cannot be flattened.
Edges EdgesOf(const Curve& curve) {
  const auto flat = FlattenCurve(curve);
  Edges edges;
  if (!flat) return edges;
  const PointList& points = flat->points_mm;
  for (std::size_t i = 0; i < points.size(); ++i) {
    edges.push_back(contour::MakeLine(points[i].head<2>(),
                                      points[(i + 1) % points.size()].head<2>()));
  }
  return edges;
}

/// Whether the outlines of two curves have a point in common.
bool Cross(const Curve& a, const Curve& b) {
  const Edges edges = EdgesOf(a), others = EdgesOf(b);
  if (edges.empty() || others.empty()) return false;
  const EdgeTree tree(edges);
  std::vector<Vec2> points;
  return std::ranges::any_of(others, [&](const Edge& other) {
    const auto near = tree.EdgesIn(contour::FlatBoxOf(other));
    return std::ranges::any_of(near, [&](std::uint32_t k) {
      contour::AppendCrossings(edges[k], other, points);
      return !points.empty();
    });
  });
}

}  // namespace

void UniteLetters(const std::vector<std::uint32_t>& letters, std::vector<Curve>& curves) {
  if (curves.empty()) return;
  std::vector<FlatBox> boxes;
  for (const Curve& curve : curves) boxes.push_back(BoxOf(curve));
  Groups groups(*std::ranges::max_element(letters) + 1);
  std::set<std::uint32_t> joined;  // letters
  std::vector<std::size_t> by_x(curves.size());
  std::iota(by_x.begin(), by_x.end(), 0u);
  std::ranges::sort(by_x, {}, [&](std::size_t i) { return boxes[i].min_mm.x(); });
  for (std::size_t a = 0; a < by_x.size(); ++a) {
    const std::size_t i = by_x[a];
    for (std::size_t b = a + 1; b < by_x.size(); ++b) {
      const std::size_t j = by_x[b];
      if (boxes[j].min_mm.x() > boxes[i].max_mm.x()) break;
      if (!Meet(boxes[i], boxes[j]) || groups.Find(letters[i]) == groups.Find(letters[j]))
        continue;
      if (!Cross(curves[i], curves[j])) continue;
      groups.Join(letters[i], letters[j]);
      joined.insert({letters[i], letters[j]});
    }
  }
  if (joined.empty()) return;
  std::map<std::uint32_t, std::vector<Curve>> outlines;  // by the first letter
  for (std::size_t i = 0; i < curves.size(); ++i) {
    if (joined.contains(letters[i]))
      outlines[groups.Find(letters[i])].push_back(curves[i]);
  }
  ClipWork work;
  std::map<std::uint32_t, std::vector<Curve>> united;
  for (const auto& [first, separate] : outlines) {
    if (const auto area = ClipArea::OfShapes({{separate, false}}, work))
      united[first] = area->AsShape().outlines;
  }
  std::vector<Curve> all;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const auto found = united.find(groups.Find(letters[i]));
    if (found == united.end()) {
      all.push_back(std::move(curves[i]));
      continue;
    }
    for (Curve& outline : std::exchange(found->second, {}))
      all.push_back(std::move(outline));
  }
  curves = std::move(all);
}

}  // namespace intaglio::drawing
