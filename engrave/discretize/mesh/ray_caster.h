#pragma once

// Which rays of a grid cross which triangles, and where. A ray through an edge or a
// vertex counts once: it is treated as shifted by an infinitesimal step, the same for all
// triangles, and the side of an edge on which it passes is decided exactly. So a closed
// mesh has an even number of crossings on every ray. Frame of the rays (ray_grid.h), mm.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/result.h"
#include "engrave/core/try.h"
#include "engrave/discretize/mesh/ray_grid.h"
#include "engrave/discretize/mesh/ray_heights.h"
#include "engrave/discretize/mesh/ray_sweep.h"
#include "engrave/discretize/spacing/candidate_limit.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

class RayCaster {
 public:
  /// Vertices in the rays' frame.
  RayCaster(const RayGrid& grid, const PointList& vertices);

  /// Calls visit(column, row, heights) for each ray that crosses one of these triangles,
  /// row by row and by columns in it, with a span of the heights (double) of its
  /// crossings from the lowest up. kTooLarge when there are more crossings, or rows that
  /// triangles reach, than candidate_limit.h allows; rays may have been visited then. May
  /// be called from several threads at once.
  template <typename Visit>
  Status Cast(std::span<const mesh::Triangle> triangles, const Visit& visit) const;

  /// Estimated number of crossings of these triangles: their area across the rays, in
  /// cells of the grid.
  double CrossingsAbout(std::span<const mesh::Triangle> triangles) const;

  const RayGrid& grid() const { return grid_; }

 private:
  RayGrid grid_;
  std::vector<RayCorner> corners_;
};

template <typename Visit>
Status RayCaster::Cast(std::span<const mesh::Triangle> triangles,
                       const Visit& visit) const {
  RaySweep sweep(grid_, corners_, triangles);
  INTAGLIO_TRY(CheckCandidateCount(sweep.reached_row_count()));
  RayHeights heights(grid_.column_count);
  double crossing_count = 0;
  while (sweep.Next()) {
    crossing_count += heights.Receive(sweep.spans());
    INTAGLIO_TRY(CheckCandidateCount(crossing_count));
    heights.ForEachRay([&](std::uint32_t column, std::span<const double> ray) {
      visit(column, sweep.row(), ray);
    });
  }
  return {};
}

}  // namespace intaglio::discretize
