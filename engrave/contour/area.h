#pragma once

// Areas that a union is made of: an element grown by the tool's radius, as edges with the
// area to their left, and the signed distance of any point.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engrave/contour/edge_tree.h"
#include "engrave/contour/element.h"

namespace intaglio::contour {

/// All points nearer than margin_mm to a convex core (a point, a segment, or a polygon
/// that runs counter-clockwise), or, with an empty core, what an odd number of the
/// edges' loops encloses.
struct Area {
  std::vector<Vec2> core_mm;
  double margin_mm = 0;
  Edges edges;  ///< the area lies to the left
  /// Of each edge its middle, and how far its other points are from there at most.
  struct Middle {
    Vec2 place_mm;
    double reach_mm;
  };
  std::vector<Middle> middles;
  std::shared_ptr<const EdgeTree> tree;  ///< of loops with many edges, else null
  Vec2 min_mm;
  Vec2 max_mm;
  std::uint32_t element = 0;
};

/// Negative inside. Of a polygon without a margin, outside near a corner: the distance to
/// the lines through its sides, which is at most that to the polygon.
double Depth(const Area& area, const Vec2& point_mm);

/// The numbers of the area's edges that may come near to this box, ascending.
std::vector<std::uint32_t> EdgesNear(const Area& area, const FlatBox& box_mm);

/// Appends the areas of a rounded element grown by radius_mm >= 0, all with this number.
/// Most elements are one area; an outline that is not a convex polygon is its inside and
/// what the tool sweeps along its edges. Fails with kInvalidValue, names the element and
/// the place: grown it is thinner than 1 um, or an outline touches or crosses itself.
Status AppendGrown(const Element& element, std::uint32_t number, double radius_mm,
                   Corners corners, std::vector<Area>& areas);

/// core_mm: one place, two that differ, or a convex polygon, counter-clockwise;
/// margin_mm > 0 for the first two.
Area ConvexArea(std::vector<Vec2> core_mm, double margin_mm);
/// Loops with the area to their left.
Area LoopArea(const std::vector<Edges>& loops);

}  // namespace intaglio::contour
