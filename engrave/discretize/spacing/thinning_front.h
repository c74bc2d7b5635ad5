#pragma once

// The points that thinning keeps, added from the lowest up, and the check whether a point
// is too near to any of them.

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <unordered_map>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/discretize/spacing/columns.h"
#include "engrave/discretize/spacing/thinning.h"

namespace intaglio::discretize {

/// The bounds known in advance for the points of one source.
struct SourceExtent {
  Box3 bounds;
  std::size_t count = 0;
  float max_spacing_mm = 0;
  float min_spacing_mm = std::numeric_limits<float>::infinity();
};
using SourceExtents = std::unordered_map<std::uint32_t, SourceExtent>;

/// The points of one source by their own spacings: one grid for each power of two, so
/// that a grid's columns fit the spacings of its points.
class OwnSpacings {
 public:
  OwnSpacings(const SourceExtent& extent, double min_spacing_mm, const Vec3& rise);

  void Add(const ThinningPoint& point) {
    Level& level = levels_[LevelOf(point.spacing_mm)];
    level.min_mm = std::min<double>(level.min_mm, point.spacing_mm);
    level.columns.Add(point.p_mm, point.spacing_mm);
  }
  std::size_t KeepFar(std::span<ThinningPoint> points) const;

 private:
  struct Level {
    double reach_mm;  ///< upper bound of the spacings of its points
    double min_mm;    ///< lower bound of the spacings of its points
    Columns columns;
  };
  std::size_t KeepFar(std::span<ThinningPoint> points, const Level& level) const;
  std::size_t LevelOf(double spacing_mm) const;

  double max_spacing_mm_;
  std::vector<Level> levels_;  // each with spacings of half the one before
};

class ThinningFront {
 public:
  ThinningFront(const ThinningOptions& options, const Box3& bounds,
                std::size_t point_count, const SourceExtents& extents);

  /// In rising height along options.rise.
  void Add(const ThinningPoint& point);
  /// Moves the points that are not too near to any point added so far to the front and
  /// returns their number. Not to be called from two threads at once.
  std::size_t KeepFar(std::span<ThinningPoint> points);
  /// Whether they are too near by the rules of weld.h.
  bool AreTooNear(const ThinningPoint& p, const ThinningPoint& q) const;

 private:
  std::size_t KeepFarFromAll(std::span<ThinningPoint> points) const;
  OwnSpacings* OwnOf(std::uint32_t source);

  /// All points are of one source, whose spacing is larger than the block's minimum.
  bool own_is_enough_ = false;
  double height_ratio_;
  double min_square_, min_mm_;
  double surely_near_, surely_far_;  // bounds on a square from the fast computation
  double reach_mm_;
  Columns columns_;
  std::unordered_map<std::uint32_t, OwnSpacings> own_;
  // Points come in runs of one source.
  std::uint32_t last_source_ = 0;
  OwnSpacings* last_own_ = nullptr;
};

}  // namespace intaglio::discretize
