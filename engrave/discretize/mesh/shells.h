#pragma once

// Surfaces below a surface. Glass frame, mm.

#include <cstdint>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/discretize/mesh/surface_grid.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

/// The mesh with its vertices moved inward, so that the planes of the triangles around
/// each move by depth_mm: exactly on a plane, an edge or a corner of three faces, by
/// least squares elsewhere. Vertices and triangles keep their numbers. Where the model is
/// thinner than twice the depth, or turns inward more tightly than the depth, the result
/// intersects itself: DepthCheck reports where.
mesh::TriangleMesh Inward(const mesh::TriangleMesh& mesh, double depth_mm);

/// Checks whether places are at the depth of a shell below a surface.
class DepthCheck {
 public:
  /// Of a shell depth_mm (> 0) below the surface of the mesh. Memory is proportional to
  /// the surface area divided by the square of a quarter of the depth. kTooLarge: see
  /// candidate_limit.h.
  static Result<DepthCheck> Make(const mesh::TriangleMesh& mesh, double depth_mm);

  /// True when the surface is nowhere nearer than 0.9 depths, false when it is nearer
  /// than 0.87 somewhere.
  bool IsDeep(const Vec3& p_mm) const;

 private:
  DepthCheck(const Box3& bounds, double depth_mm, PointList samples);
  std::size_t ColumnOf(double x_mm, double y_mm) const;

  Vec2 origin_;
  double reach_mm_, per_side_;
  std::size_t width_, depth_;
  std::vector<std::uint32_t> begin_;  // of each column in samples_
  PointList samples_;                 // by column, then z
};

}  // namespace intaglio::discretize
