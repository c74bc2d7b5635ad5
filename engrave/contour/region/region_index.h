#pragma once

// Points in regions of many edges, long ones among them: a tree of their boxes.

#include <optional>
#include <vector>

#include "engrave/contour/edge_tree.h"
#include "engrave/contour/region/region.h"

namespace intaglio::contour {

/// The box of an edge, its arc included.
struct EdgeBox {
  Vec2 min_mm;
  Vec2 max_mm;
};
EdgeBox BoxOfEdge(const Edge& edge);
EdgeBox BoxOfEdges(const Edges& edges);     ///< at least one
EdgeBox BoxOfRegion(const Region& region);  ///< at least one loop

class RegionIndex {
 public:
  explicit RegionIndex(const Region& region);
  /// On the border: either.
  bool IsInside(const Vec2& point_mm) const { return tree_ && tree_->IsInside(point_mm); }
  const Edges& edges() const { return edges_; }  ///< of all loops, in their order
  double area_mm2() const { return area_mm2_; }

 private:
  Edges edges_;
  double area_mm2_ = 0;
  std::optional<EdgeTree> tree_;  ///< none of no edges
};

/// The difference and the intersection of two regions at once.
struct Combined {
  Region outside;  ///< of a, what is not in b
  Region inside;   ///< of a, what is in b
  double inside_area_mm2 = 0;
};
Result<Combined> Combine(const Region& a, const Region& b);

}  // namespace intaglio::contour
