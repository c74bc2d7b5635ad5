#pragma once

// What every method of discretization makes of a model: a source of candidates for the
// weld, that can be asked for any range of heights. So a job can be cut into slabs, over
// cores and over processes, and nobody keeps more candidates than its slab has.

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

  /// Of all points it can give; may be larger. Glass frame, mm; empty: it has none.
  virtual Box3 Bounds() const = 0;

  /// The largest own spacing of its points, mm; 0 when they have none.
  virtual double MaxSpacing() const { return 0; }

  /// Appends the points whose z lies in the range, with `source` as their source. The
  /// points of ranges that share nothing are together those of the ranges' union, bit for
  /// bit, in whatever order; so are the statistics. May be called from several threads at
  /// once. kTooLarge for more points than candidate_limit.h allows, kCancelled when
  /// `progress` says so.
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
