#pragma once

// The lattices that surface_grid.h projects.

#include <array>
#include <functional>

#include "engrave/core/geometry.h"
#include "engrave/discretize/spacing/point_source.h"

namespace intaglio::discretize {

/// The corners of a triangle, glass frame, mm.
using Corners = std::array<Vec3, 3>;

/// Across one direction: nodes (i + j / 2, j sqrt(3) / 2) step_mm, and a shift, in its
/// plane (u, v).
struct LatticeFrame {
  Mat3 uvw_from_glass;  ///< rotation; w is the direction
};

inline constexpr std::size_t kLatticeFrames = 13;
/// Along the edges, face diagonals and space diagonals of a cube: no normal is farther
/// than 28 degrees from one of them.
const std::array<LatticeFrame, kLatticeFrames>& LatticeFrames();

/// The frame whose direction is nearest to the normal, or to its opposite.
const LatticeFrame& FrameFor(const Vec3& normal);

/// Calls `visit(p, i, j)` for the nodes on the triangle with p.z() in the range. `normal`
/// is the cross product of its edges; without one it may be zero. Nodes on an edge or
/// vertex are those of one of the triangles around it that have the same frame, if these
/// make a surface.
void ForEachNode(
    const Corners& corners, const Vec3& normal, const LatticeFrame& frame, double step_mm,
    const HeightRange& range,
    const std::function<void(const Vec3&, std::int64_t, std::int64_t)>& visit);

}  // namespace intaglio::discretize
