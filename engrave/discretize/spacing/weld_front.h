#pragma once

// What a weld keeps: points that are added from the lowest up, and the question whether
// one is too near to any of them.

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <unordered_map>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/discretize/spacing/columns.h"
#include "engrave/discretize/spacing/weld.h"

namespace intaglio::discretize {

/// What is known beforehand of the points of one source.
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
  OwnSpacings(const SourceExtent& extent, double min_spacing_mm);

  void Add(const WeldPoint& point) {
    Level& level = levels_[LevelOf(point.spacing_mm)];
    level.least_mm = std::min<double>(level.least_mm, point.spacing_mm);
    level.columns.Add(point.p_mm, point.spacing_mm);
  }
  std::size_t KeepFar(std::span<WeldPoint> points) const;

 private:
  struct Level {
    double reach_mm;  ///< at least the spacings of its points
    double least_mm;  ///< at most these
    Columns columns;
  };
  std::size_t KeepFar(std::span<WeldPoint> points, const Level& level) const;
  std::size_t LevelOf(double spacing_mm) const;

  double max_spacing_mm_;
  std::vector<Level> levels_;  // each with spacings of half the one before
};

class WeldFront {
 public:
  WeldFront(const WeldOptions& options, const Box3& bounds, std::size_t point_count,
            const SourceExtents& extents);

  /// In rising z.
  void Add(const WeldPoint& point);
  /// Moves those that are not too near to a point added so far to the front and tells how
  /// many they are. Not of two threads at once.
  std::size_t KeepFar(std::span<WeldPoint> points);
  /// By the rules of weld.h.
  bool AreTooNear(const WeldPoint& p, const WeldPoint& q) const;

 private:
  std::size_t KeepFarFromAll(std::span<WeldPoint> points) const;
  OwnSpacings* OwnOf(std::uint32_t source);

  /// All points are of one source, which keeps them farther apart than the block asks.
  bool own_is_enough_ = false;
  double height_ratio_;
  double least_square_, least_mm_;
  double surely_near_, surely_far_;  // bounds on a square that was computed in haste
  double reach_mm_;
  Columns columns_;
  std::unordered_map<std::uint32_t, OwnSpacings> own_;
  // Points come in runs of one source.
  std::uint32_t last_source_ = 0;
  OwnSpacings* last_own_ = nullptr;
};

}  // namespace intaglio::discretize
