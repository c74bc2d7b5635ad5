#pragma once

// The product of every method of discretization: a source of candidates for thinning,
// which gives those of any range of heights. So a job can be cut into slabs for several
// cores and processes, and each of them holds only the candidates of its slab.

#include <limits>
#include <memory>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/discretize/spacing/spaced_cloud.h"
#include "engrave/discretize/spacing/statistics.h"

namespace intaglio::discretize {

/// low <= z < high, glass frame, mm.
struct HeightRange {
  double low_mm = -std::numeric_limits<double>::infinity();
  double high_mm = std::numeric_limits<double>::infinity();

  bool Contains(double z_mm) const { return z_mm >= low_mm && z_mm < high_mm; }
};

class PointSource {
 public:
  virtual ~PointSource() = default;

  /// Encloses all points it can give; may be larger. Glass frame, mm; empty: it has none.
  virtual Box3 Bounds() const = 0;

  /// The largest own spacing of its points, mm; 0 when they have none.
  virtual double MaxSpacing() const { return 0; }

  /// Appends the points whose z lies in the range, with `source` as their source. The
  /// points of disjoint ranges together are those of the ranges' union, bit for bit, in
  /// any order; so are the statistics. May be called from several threads at once.
  /// kTooLarge for more points than candidate_limit.h allows, kCancelled when `progress`
  /// returns false.
  virtual Result<MethodStatistics> AddPoints(const HeightRange& range,
                                             std::uint32_t source,
                                             const ProgressSink& progress,
                                             SpacedCloud& cloud) const = 0;

 protected:
  PointSource() = default;
  PointSource(const PointSource&) = default;
  PointSource& operator=(const PointSource&) = default;
};

}  // namespace intaglio::discretize
