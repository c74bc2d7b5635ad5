#pragma once

// Candidates all over a surface at a given step. Their number depends on its area and not
// on its triangles.
//
// The nodes of a triangular lattice are projected onto the surface, along whichever of 13
// directions is nearest to a triangle's normal: triangles of the same direction share one
// lattice, and a candidate on their common edge belongs to one of them. So a fine mesh
// has as many candidates as a coarse one of the same shape, and a triangle without any is
// covered by its neighbourhood.
//
// Features that a lattice can miss (corners, spikes, threads and slivers) get points of
// their own: vertices, and edges of narrow triangles, at most one for each cube of the
// step.

#include <cstdint>
#include <functional>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/discretize/spacing/interval_index.h"
#include "engrave/discretize/spacing/point_source.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

struct SurfacePoint {
  Vec3 p_mm;
  std::uint32_t triangle;  ///< it lies on, or one of them
  /// It is of the lattice of 2^level times the step, too. Own points are of all.
  int level;
};

struct SurfaceGridOptions {
  double step_mm = 0.02;  ///< > 0, of the lattice: every place is nearer than about that
  /// Points of their own for vertices and narrow triangles.
  bool own_points = true;
  /// And for every edge, so that the outlines of faces show.
  bool all_edges = false;
};

class SurfaceGrid {
 public:
  static constexpr int kMaxLevel = 12;

  /// Keeps a reference to the mesh. Glass frame, mm.
  SurfaceGrid(const mesh::TriangleMesh& mesh, const SurfaceGridOptions& options);

  const Box3& bounds() const { return bounds_; }
  double step_mm() const { return options_.step_mm; }

  /// Calls `visit` for the candidates in the range, in no particular order. The
  /// statistics count the small triangles (no edge as long as the step) and those without
  /// area, each in the range that holds its lowest corner. Errors kTooLarge and
  /// kCancelled as of PointSource. May be called from any thread.
  using Visitor = std::function<void(const SurfacePoint&)>;
  Result<MethodStatistics> ForEach(const HeightRange& range, const ProgressSink& progress,
                                   const Visitor& visit) const;

 private:
  class Walk;
  void FindFirstCorners();
  Interval HeightsOf(double low_mm, double high_mm) const;

  const mesh::TriangleMesh& mesh_;
  SurfaceGridOptions options_;
  Box3 bounds_;
  double heights_per_mm_ = 1;
  IntervalIndex by_height_;
  // Of each triangle, a bit for each corner that no earlier triangle has.
  std::vector<std::uint8_t> first_corners_;
};

}  // namespace intaglio::discretize
