#pragma once

// The edges of an area in a tree of boxes, so that a point of an outline of many edges
// costs the logarithm of their number. Frame: drawing, mm.

#include <cstdint>
#include <vector>

#include "engrave/contour/edge.h"
#include "engrave/contour/near_pairs.h"

namespace intaglio::contour {

/// The box of an edge, its arc included.
FlatBox FlatBoxOf(const Edge& edge);

/// Keeps a copy of the edges. Const and without a state: any number of threads may ask.
class EdgeTree {
 public:
  /// At least one edge.
  explicit EdgeTree(const Edges& edges);

  /// To the nearest edge.
  double DistanceTo(const Vec2& point_mm) const;
  /// As IsInLoops of the same edges.
  bool IsInside(const Vec2& point_mm) const { return Winding(point_mm) % 2 != 0; }
  /// How often closed loops run around the point; on an edge: the number of either side.
  int Winding(const Vec2& point_mm) const;
  /// The numbers of the edges whose boxes meet this one, ascending.
  std::vector<std::uint32_t> EdgesIn(const FlatBox& box_mm) const;

 private:
  struct Node {
    FlatBox box;
    std::uint32_t begin = 0;  ///< of its edges in order_
    std::uint32_t end = 0;
    std::uint32_t right = 0;  ///< node; the left one is the next; 0: a leaf
  };

  std::uint32_t Build(std::uint32_t begin, std::uint32_t end);
  void FindNearest(std::uint32_t node, const Vec2& point_mm, double& distance_mm) const;
  template <typename Accept, typename Visit>
  void ForEach(const Accept& accept, const Visit& visit) const;

  Edges edges_;
  std::vector<FlatBox> boxes_;  ///< of each edge
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace intaglio::contour
