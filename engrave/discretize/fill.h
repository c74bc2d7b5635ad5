#pragma once

// Triangle fill ("Filling faces", Trochimczuk 2008 annex B): every triangle gets points
// of its own. The source's points crowd where triangles meet and miss small triangles;
// here each triangle offers candidates at half the distance, small ones their centre, and
// the weld over the whole cloud (weld.h) takes as many as fit. Frame glass, mm.

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/discretize/statistics.h"
#include "engrave/mesh/mesh.h"

namespace intaglio::discretize {

struct FillOptions {
  double vertex_distance_mm = 1;  ///< 0.01..100; the weld brings the points to it
  bool full_fill = true;          ///< candidates on the edges, too: boundaries show
};

/// Appends the candidates to `cloud`. kTooLarge for more than candidate_limit.h allows,
/// kCancelled when `progress` says so.
Result<MethodStatistics> FillTriangles(const mesh::TriangleMesh& mesh,
                                       const FillOptions& options, std::uint32_t source,
                                       const ProgressSink& progress, PointCloud& cloud);

}  // namespace intaglio::discretize
