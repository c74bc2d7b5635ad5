#pragma once

// What a weld keeps: points that are added from the lowest up, and the question whether
// one is too near to any of them.

#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/discretize/weld.h"

namespace intaglio::discretize {

struct WeldPoint {
  Vec3 p_mm;
  std::uint32_t source;
  float spacing_mm;
};

/// A grid of columns in x and y, each with its points from the newest down. Points are
/// added in rising z, so what is near to a place at their upper end is found at the
/// beginning of a few columns: the part of them that is read stays in the cache.
class Columns {
 public:
  /// For points within the bounds and questions that reach `reach_mm` or a little
  /// farther; the columns are wider when `point_count` points do not justify as many.
  Columns(const Box3& bounds, double reach_mm, std::size_t point_count);

  bool empty() const { return entries_.empty(); }
  void Add(const Vec3& p_mm, float spacing_mm) {
    std::uint32_t& newest = newest_[ColumnOf(p_mm)];
    entries_.push_back({p_mm, newest, spacing_mm});
    newest = static_cast<std::uint32_t>(entries_.size() - 1);
  }

  /// Whether too_near(q, spacing of q) is true of a point q whose x and y differ from
  /// those of p by less than reach_mm and which is not lower by reach_z_mm or more.
  template <typename TooNear>
  bool Any(const Vec3& p_mm, double reach_mm, double reach_z_mm,
           const TooNear& too_near) const {
    const double stop_mm = p_mm.z() - reach_z_mm;
    const auto in_column = [&](std::size_t column) {
      for (std::uint32_t at = newest_[column]; at != kNone; at = entries_[at].below) {
        const Entry& q = entries_[at];
        if (q.p_mm.z() <= stop_mm) return false;  // and all below it
        if (too_near(q.p_mm, q.spacing_mm)) return true;
      }
      return false;
    };
    const std::size_t own = ColumnOf(p_mm), w = width_;
    if (reach_mm > side_mm_) return AnyInSquare(p_mm, reach_mm, in_column);
    // The own column answers most often, the corners least.
    return in_column(own) || in_column(own - 1) || in_column(own + 1) ||
           in_column(own - w) || in_column(own + w) || in_column(own - w - 1) ||
           in_column(own - w + 1) || in_column(own + w - 1) || in_column(own + w + 1);
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  struct Entry {
    Vec3 p_mm;
    std::uint32_t below;  ///< in the same column
    float spacing_mm;
  };

  std::size_t ColumnOf(const Vec3& p_mm) const {
    const auto x = static_cast<std::size_t>((p_mm.x() - origin_.x()) / side_mm_);
    const auto y = static_cast<std::size_t>((p_mm.y() - origin_.y()) / side_mm_);
    return (y + 1) * width_ + x + 1;
  }

  template <typename InColumn>
  bool AnyInSquare(const Vec3& p_mm, double reach_mm, const InColumn& in_column) const {
    const auto at = [this](double offset_mm, std::size_t count) {
      return static_cast<std::size_t>(
          std::clamp(offset_mm / side_mm_ + 1, 0.0, static_cast<double>(count - 1)));
    };
    const double x = p_mm.x() - origin_.x(), y = p_mm.y() - origin_.y();
    const std::size_t x_end = at(x + reach_mm, width_), y_end = at(y + reach_mm, depth_);
    for (std::size_t j = at(y - reach_mm, depth_); j <= y_end; ++j) {
      for (std::size_t i = at(x - reach_mm, width_); i <= x_end; ++i) {
        if (in_column(j * width_ + i)) return true;
      }
    }
    return false;
  }

  Vec2 origin_;
  double side_mm_;
  // A border of empty columns all around saves the question whether there is one.
  std::size_t width_, depth_;
  std::vector<std::uint32_t> newest_;  // of each column, in entries_
  std::vector<Entry> entries_;
};

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
    levels_[LevelOf(point.spacing_mm)].columns.Add(point.p_mm, point.spacing_mm);
  }
  bool IsTooNear(const WeldPoint& point) const;

 private:
  struct Level {
    double reach_mm;  ///< the largest spacing of its points
    Columns columns;
  };
  bool IsTooNear(const WeldPoint& point, const Level& level) const;
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
  /// To a point added so far. Not of two threads at once.
  bool IsTooNear(const WeldPoint& point);

 private:
  bool IsTooNearToAny(const Vec3& p_mm) const;
  OwnSpacings* OwnOf(std::uint32_t source);

  double height_ratio_;
  double least_square_;
  double surely_near_, surely_far_;  // bounds on a square that was computed in haste
  double reach_mm_;
  Columns columns_;
  std::unordered_map<std::uint32_t, OwnSpacings> own_;
  // Points come in runs of one source.
  std::uint32_t last_source_ = 0;
  OwnSpacings* last_own_ = nullptr;
};

}  // namespace intaglio::discretize
