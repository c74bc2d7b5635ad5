#pragma once

// Makes the cloud of a job from its sources, slab by slab: candidates, bounds, thinning.
// Memory is proportional to the points, plus the candidates of the slabs in progress.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engrave/core/executor.h"
#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/discretize/slabs.h"
#include "engrave/discretize/spacing/point_source.h"
#include "engrave/discretize/spacing/thinning.h"

namespace intaglio::discretize {

struct CloudOptions {
  ThinningOptions thinning;  ///< over the whole block
  Box3 permitted_mm;         ///< the block minus its margin, glass frame
  /// By the number of a source, when their blocks differ; empty: permitted_mm.
  std::vector<Box3> permitted_of_source_mm = {};
  bool clip = false;  ///< drop points outside instead of failing
};

struct Discretized {
  PointCloud cloud;  ///< glass frame; slab by slab, from the lowest up
  std::uint64_t candidate_count = 0;
  std::uint64_t clipped_count = 0;
  std::uint64_t thinned_count = 0;       ///< removed by thinning
  std::vector<MethodStatistics> models;  ///< one a source
};

using Sources = std::vector<std::unique_ptr<PointSource>>;

/// The points of a part of the job; those of all parts, one after another, are the cloud,
/// bit for bit, whatever the number of parts and workers, and the counts add up. A
/// point's source is the index of its PointSource. Errors: kOutsideBlock,
/// kCancelled, those of the sources. A part may have no points.
Result<Discretized> MakeCloud(const Sources& sources, const CloudOptions& options,
                              const Part& part, const Executor& executor,
                              const ProgressSink& progress);

/// kMissing, with the remedy, for a job without any point.
Error NoPoints();

}  // namespace intaglio::discretize
