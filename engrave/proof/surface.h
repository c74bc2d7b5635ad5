#pragma once

// The surface that a cloud should show, in the form that the measurements use: the
// triangles of all placed models, cut so small that a patch of them can have any area, in
// a tree of boxes that finds the place of the surface nearest to a point.

#include <array>
#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::proof {

using Corners = std::array<Vec3, 3>;

double AreaOf(const Corners& triangle);

/// The two halves of a triangle, cut from the middle of its longest side; so long
/// triangles come apart into short ones.
std::array<Corners, 2> HalvesOf(const Corners& triangle);

/// The place of the triangle nearest to a point; exact to rounding, for triangles
/// without an area, too.
Vec3 NearestPlaceOf(const Corners& triangle, const Vec3& p_mm);

class Surface {
 public:
  /// Cuts triangles until none is larger than max_area_mm2 > 0, but into no more than
  /// `max_pieces` beyond their number. Glass frame, mm, finite; at least one triangle.
  Surface(const std::vector<mesh::TriangleMesh>& models, double max_area_mm2,
          std::size_t max_pieces);

  /// Spatially sorted: neighbours in the list mostly are neighbours in space.
  const std::vector<Corners>& triangles() const { return triangles_; }

  struct Place {
    std::uint32_t triangle = 0;
    Vec3 at_mm = Vec3::Zero();
    double square_mm2 = 0;  ///< of its distance from the point
  };
  /// The place nearest to a point. `near_triangle`: one that is likely to be near, e.g.
  /// that of the last point; of equally near triangles it, or else any of them.
  Place NearestTo(const Vec3& p_mm, std::uint32_t near_triangle) const;

 private:
  struct Node {
    Box3 box;
    std::uint32_t begin = 0, end = 0;  ///< triangles
    std::uint32_t right = 0;           ///< the left child is the next node; 0: a leaf
  };
  void Build(std::vector<Corners>& triangles, std::uint32_t begin, std::uint32_t end);

  std::vector<Corners> triangles_;
  std::vector<Node> nodes_;
};

}  // namespace intaglio::proof
