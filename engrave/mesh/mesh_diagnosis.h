#pragma once

#include <cstdint>
#include <string_view>

#include "engrave/core/warning.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::mesh {

/// Counts of the defects of a surface. Meant for a placed mesh (glass frame, mm); the
/// counts are the same before placement. "Edge" is a pair of vertices that some triangle
/// joins; triangles with a repeated corner have no part in the edges.
struct MeshDiagnosis {
  std::uint64_t triangle_count = 0;
  std::uint64_t vertex_count = 0;  ///< used by a triangle
  std::uint64_t edge_count = 0;
  /// Parts: sets of triangles connected by edges.
  std::uint64_t component_count = 0;

  /// A corner is repeated, or twice the area is at most 1e-12 of the longest edge's
  /// square: zero except for the rounding of doubles.
  std::uint64_t degenerate_triangle_count = 0;
  /// Triangles whose three corners another triangle already has, in any order.
  std::uint64_t duplicate_triangle_count = 0;
  std::uint64_t open_edge_count = 0;          ///< of one triangle only: a hole's border
  std::uint64_t non_manifold_edge_count = 0;  ///< of more than two triangles
  /// Edges of two triangles that pass it the same way: one of them faces inward.
  std::uint64_t flipped_edge_count = 0;
  /// The minimum number of triangles to turn over so that neighbours agree, counted in
  /// each part separately (neighbours across edges of exactly two triangles).
  std::uint64_t flipped_triangle_count = 0;
  /// A part cannot be turned so that all neighbours agree (a Moebius strip).
  bool orientable = true;

  Box3 bounds_mm;  ///< of the vertices in use
  double area_mm2 = 0;
  /// Positive when the faces point outward. A volume only if closed().
  double signed_volume_mm3 = 0;

  /// Every edge has exactly two triangles, so that inside and outside are defined.
  bool closed() const {
    return triangle_count > 0 && edge_count > 0 && open_edge_count == 0 &&
           non_manifold_edge_count == 0;
  }
  /// The faces point inward: the volume is negative, of a closed surface whose neighbours
  /// agree, or of one with few open edges and flipped triangles (5 %) that encloses more
  /// than 2 % of its bounding box.
  bool inside_out() const;
  /// V - E + F without the triangles that have a repeated corner; 2 for a sphere.
  std::int64_t euler_characteristic = 0;
};

/// Linear in the triangles. No more than kMaxHalfEdgeTriangles (half_edges.h).
MeshDiagnosis Diagnose(const TriangleMesh& mesh);

/// Each begins with the model's name; none for a clean, closed surface.
Warnings WarningsOf(const MeshDiagnosis& diagnosis, std::string_view model_name);

}  // namespace intaglio::mesh
