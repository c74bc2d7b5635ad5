#pragma once

// Sections ("Cutting faces", Trochimczuk 2008 annex A): parallel planes cut the mesh, and
// every contour gets points at equal arc length. Frame glass, mm.
//
// Known weakness of the method: a face parallel to the planes is not cut. Its area is
// reported (MethodStatistics::parallel_area_mm2), so that nobody loses a base unawares.

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/discretize/direction.h"
#include "engrave/discretize/statistics.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

struct SectionOptions {
  double layer_distance_mm = 1;   ///< 0.01..100
  double vertex_distance_mm = 1;  ///< 0.01..100, along a contour
  /// First and last plane lie at least this share of the layer distance within the
  /// object's extent, 0..1.
  double first_last_distance_ratio = 0.1;
  /// Each next layer begins shifted by this share of the vertex distance, 0..1.
  double twist_phase_ratio = 0;
  /// Keep the points at both ends of an open contour.
  bool insert_end_points = true;
  Direction normal;
};

/// Appends to `cloud`, with `source` as every point's source. Planes in the order of
/// their height; a plane passes below a vertex that lies exactly in it, so that every
/// contour of a closed mesh is closed. kTooLarge for more points or planes than
/// candidate_limit.h allows, kCancelled when `progress` says so.
Result<MethodStatistics> CutSections(const mesh::TriangleMesh& mesh,
                                     const SectionOptions& options, std::uint32_t source,
                                     const ProgressSink& progress, PointCloud& cloud);

}  // namespace intaglio::discretize
