// Built by halves: the edges of a node are divided at the median of the middles of their
// boxes along the longer side. Depth: the logarithm of their number.
#include "engrave/contour/edge_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "engrave/contour/simple_loops.h"
#include "engrave/core/check.h"

namespace intaglio::contour {
namespace {

constexpr std::uint32_t kEdgesOfLeaf = 8;

double DistanceToBox(const FlatBox& box, const Vec2& p) {
  return (p - p.cwiseMax(box.min_mm).cwiseMin(box.max_mm)).norm();
}

void Extend(FlatBox& box, const FlatBox& by) {
  box.min_mm = box.min_mm.cwiseMin(by.min_mm);
  box.max_mm = box.max_mm.cwiseMax(by.max_mm);
}

}  // namespace

FlatBox FlatBoxOf(const Edge& edge) {
  FlatBox box{edge.begin_mm.cwiseMin(edge.end_mm), edge.begin_mm.cwiseMax(edge.end_mm)};
  if (!edge.is_arc()) return box;
  const Vec2 middle = PointAt(edge, edge.length_mm / 2);
  const Vec2 reach =
      Vec2::Constant(2 * edge.radius_mm * std::sin(std::abs(edge.sweep_rad) / 4));
  Extend(box, {middle - reach, middle + reach});
  return box;
}

EdgeTree::EdgeTree(const Edges& edges) : edges_(edges), order_(edges.size()) {
  Require(!edges.empty(), "a tree of no edges");
  for (const Edge& edge : edges_) boxes_.push_back(FlatBoxOf(edge));
  std::iota(order_.begin(), order_.end(), 0U);
  Build(0, static_cast<std::uint32_t>(edges_.size()));
}

std::uint32_t EdgeTree::Build(std::uint32_t begin, std::uint32_t end) {
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({boxes_[order_[begin]], begin, end, 0});
  for (std::uint32_t k = begin; k < end; ++k)
    Extend(nodes_[number].box, boxes_[order_[k]]);
  if (end - begin <= kEdgesOfLeaf) return number;
  const Vec2 sides = nodes_[number].box.max_mm - nodes_[number].box.min_mm;
  const int axis = sides.x() >= sides.y() ? 0 : 1;
  const std::uint32_t middle = begin + (end - begin) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                   [&](std::uint32_t a, std::uint32_t b) {
                     const double at_a = boxes_[a].min_mm[axis] + boxes_[a].max_mm[axis];
                     const double at_b = boxes_[b].min_mm[axis] + boxes_[b].max_mm[axis];
                     return at_a != at_b ? at_a < at_b : a < b;
                   });
  Build(begin, middle);
  const std::uint32_t right = Build(middle, end);
  nodes_[number].right = right;
  return number;
}

void EdgeTree::FindNearest(std::uint32_t node, const Vec2& point_mm,
                           double& distance_mm) const {
  const Node& at = nodes_[node];
  if (DistanceToBox(at.box, point_mm) >= distance_mm) return;
  if (at.right == 0) {
    for (std::uint32_t k = at.begin; k < at.end; ++k)
      distance_mm =
          std::min(distance_mm, contour::DistanceTo(edges_[order_[k]], point_mm));
    return;
  }
  std::uint32_t first = node + 1, second = at.right;
  if (DistanceToBox(nodes_[second].box, point_mm) <
      DistanceToBox(nodes_[first].box, point_mm))
    std::swap(first, second);
  FindNearest(first, point_mm, distance_mm);
  FindNearest(second, point_mm, distance_mm);
}

double EdgeTree::DistanceTo(const Vec2& point_mm) const {
  double distance_mm = std::numeric_limits<double>::infinity();
  FindNearest(0, point_mm, distance_mm);
  return distance_mm;
}

template <typename Accept, typename Visit>
void EdgeTree::ForEach(const Accept& accept, const Visit& visit) const {
  std::vector<std::uint32_t> open{0};
  while (!open.empty()) {
    const std::uint32_t number = open.back();
    open.pop_back();
    const Node& node = nodes_[number];
    if (!accept(node.box)) continue;
    if (node.right != 0) {
      open.push_back(node.right);
      open.push_back(number + 1);
      continue;
    }
    for (std::uint32_t k = node.begin; k < node.end; ++k)
      if (accept(boxes_[order_[k]])) visit(order_[k]);
  }
}

// An edge that lies above, below or to the left of the point changes nothing.
int EdgeTree::Winding(const Vec2& point_mm) const {
  int winding = 0;
  ForEach(
      [&](const FlatBox& box) {
        return box.min_mm.y() <= point_mm.y() && box.max_mm.y() >= point_mm.y() &&
               box.max_mm.x() >= point_mm.x();
      },
      [&](std::uint32_t k) { winding += TurnsAround(edges_[k], point_mm); });
  return winding;
}

std::vector<std::uint32_t> EdgeTree::EdgesIn(const FlatBox& box_mm) const {
  std::vector<std::uint32_t> found;
  ForEach(
      [&](const FlatBox& box) {
        return (box.min_mm.array() <= box_mm.max_mm.array()).all() &&
               (box.max_mm.array() >= box_mm.min_mm.array()).all();
      },
      [&](std::uint32_t k) { found.push_back(k); });
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace intaglio::contour
