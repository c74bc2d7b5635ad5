#pragma once

// The product of every method of discretization: a source of candidates for thinning,
// which gives those of any range of heights. So a job can be cut into slabs for several
// cores and processes, and each of them holds only the candidates of its slab.

#include <algorithm>
#include <limits>
#include <memory>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/discretize/spacing/spaced_cloud.h"
#include "engrave/discretize/spacing/statistics.h"

namespace intaglio::discretize {

/// The direction in which the front of the thinning rises, unless a source needs another.
inline const Vec3 kUpward = Vec3::UnitZ();

/// The direction, of unit length, for points all over a surface. A front that rises along
/// z leaves the rows of points, and the seams of the slabs, level: they show as rings.
/// This one crosses the faces of an upright box, and of one turned by 45 degrees, along
/// lines between two of the three directions of a hexagonal packing, so that no row is
/// level.
Vec3 ObliqueRise();

/// low <= height < high, mm; heights are measured along the rise of a source, from the
/// origin of the glass frame.
struct HeightRange {
  double low_mm = -std::numeric_limits<double>::infinity();
  double high_mm = std::numeric_limits<double>::infinity();

  bool Contains(double height_mm) const {
    return height_mm >= low_mm && height_mm < high_mm;
  }
};

/// Between which heights along the rise a box lies.
HeightRange HeightsOf(const Box3& bounds, const Vec3& rise);

class PointSource {
 public:
  virtual ~PointSource() = default;

  /// Encloses all points it can give; may be larger. Glass frame, mm; empty: it has none.
  virtual Box3 Bounds() const = 0;

  /// The direction, of unit length, along which the heights of ranges are measured.
  virtual Vec3 Rise() const { return kUpward; }

  /// Of its points along Rise(), from lowest to highest; may be larger. Lowest above
  /// highest: it has none.
  virtual HeightRange Heights() const { return HeightsOf(Bounds(), Rise()); }

  /// The largest own spacing of its points, mm; 0 when they have none.
  virtual double MaxSpacing() const { return 0; }

  /// Appends the points whose height lies in the range, with `source` as their source.
  /// The points of disjoint ranges together are those of the ranges' union, bit for bit,
  /// in any order; so are the statistics. May be called from several threads at once.
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
