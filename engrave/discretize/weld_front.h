#pragma once

// What a weld keeps: points that are added from the lowest up, and the question whether
// one is too near to any of them.

#include <algorithm>
#include <cstdint>
#include <limits>
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
///
/// The newest four of a column stand in single precision beside one another, too: they
/// tell in a few instructions, without a branch, that most candidates are too near.
class Columns {
 public:
  /// For points within the bounds and questions that reach `reach_mm` or a little
  /// farther, with heights divided by height_ratio; the columns are wider when
  /// `point_count` points do not justify as many.
  Columns(const Box3& bounds, double reach_mm, double height_ratio,
          std::size_t point_count);

  bool empty() const { return entries_.empty(); }
  void Add(const Vec3& p_mm, float spacing_mm);

  enum class Hasty { kNear, kFar, kUnsure };
  /// Whether a point is nearer than near_mm, or none is nearer than far_mm, heights
  /// divided by height_ratio, by more than any rounding. far_mm must not be more than
  /// reach_mm.
  Hasty Look(const Vec3& p_mm, double near_mm, double far_mm) const {
    const Vec3 q = (p_mm - origin_).cwiseProduct(scale_);
    const auto x = static_cast<float>(q.x()), y = static_cast<float>(q.y()),
               z = static_cast<float>(q.z());
    const Newest* own = &newest_[ColumnOf(p_mm)];
    const auto nearest_in_row = [&](const Newest* middle) {
      Four least = {kFar, kFar, kFar, kFar};
      for (int i = -1; i <= 1; ++i) {
        const Four dx = middle[i].x - x, dy = middle[i].y - y, dz = middle[i].z - z;
        const Four square = dx * dx + dy * dy + dz * dz;
        least = square < least ? square : least;
      }
      return least;
    };
    const auto least_of = [](const Four& f) {
      return std::min(std::min(f[0], f[1]), std::min(f[2], f[3]));
    };
    const float near = std::max(0.0F, static_cast<float>(near_mm - error_mm_));
    const Four in_own_row = nearest_in_row(own);
    const float least = least_of(in_own_row);
    if (least < near * near) return Hasty::kNear;
    const Four behind = nearest_in_row(own - width_),
               before = nearest_in_row(own + width_);
    const float square = std::min(least, least_of(behind < before ? behind : before));
    if (square < near * near) return Hasty::kNear;
    const auto far = static_cast<float>(far_mm + error_mm_);
    if (square < far * far) return Hasty::kUnsure;
    // Older points than the four of a column are lower still.
    for (const Newest* middle : {own - width_, own, own + width_}) {
      for (int i = -1; i <= 1; ++i) {
        if (!(middle[i].z[middle[i].next_lane] < z - far)) return Hasty::kUnsure;
      }
    }
    return Hasty::kFar;
  }

  /// Whether too_near(q, spacing of q) is true of a point q whose x and y differ from
  /// those of p by less than reach_mm and which is not lower by reach_z_mm or more.
  template <typename TooNear>
  bool Any(const Vec3& p_mm, double reach_mm, double reach_z_mm,
           const TooNear& too_near) const {
    const double stop_mm = p_mm.z() - reach_z_mm;
    const auto in_column = [&](std::size_t column) {
      for (std::uint32_t at = newest_[column].entry; at != kNone;
           at = entries_[at].below) {
        const Entry& q = entries_[at];
        if (q.p_mm.z() <= stop_mm) return false;  // and all below it
        if (too_near(q.p_mm, q.spacing_mm)) return true;
      }
      return false;
    };
    if (reach_mm > side_mm_) return AnyInSquare(p_mm, reach_mm, in_column);
    const double x = (p_mm.x() - origin_.x()) * per_side_;
    const double y = (p_mm.y() - origin_.y()) * per_side_;
    const auto i = static_cast<std::size_t>(x), j = static_cast<std::size_t>(y);
    const std::size_t own = (j + 1) * width_ + i + 1;
    // The own column answers most often, then the sides that are nearer.
    const std::ptrdiff_t w = static_cast<std::ptrdiff_t>(width_);
    const std::ptrdiff_t dx = x - static_cast<double>(i) < 0.5 ? -1 : 1;
    const std::ptrdiff_t dy = y - static_cast<double>(j) < 0.5 ? -w : w;
    for (const std::ptrdiff_t to :
         {std::ptrdiff_t{0}, dx, dy, dx + dy, -dx, -dy, dx - dy, dy - dx, -dx - dy}) {
      if (in_column(own + static_cast<std::size_t>(to))) return true;
    }
    return false;
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  static constexpr float kFar = 1e15F;  // its square is still a number
  // Lanes as GCC and Clang have them on every processor.
  using Four [[gnu::vector_size(16)]] = float;

  struct Entry {
    Vec3 p_mm;
    std::uint32_t below;  ///< in the same column
    float spacing_mm;
  };
  /// Of a column; from the origin, heights divided by height_ratio.
  struct Newest {
    Four x = {kFar, kFar, kFar, kFar};
    Four y = x, z = -x;
    std::uint32_t entry = kNone;  ///< the last one
    std::uint32_t next_lane = 0;
  };

  std::size_t ColumnOf(const Vec3& p_mm) const {
    const auto x = static_cast<std::size_t>((p_mm.x() - origin_.x()) * per_side_);
    const auto y = static_cast<std::size_t>((p_mm.y() - origin_.y()) * per_side_);
    return (y + 1) * width_ + x + 1;
  }

  template <typename InColumn>
  bool AnyInSquare(const Vec3& p_mm, double reach_mm, const InColumn& in_column) const {
    const auto at = [this](double offset_mm, std::size_t count) {
      return static_cast<std::size_t>(
          std::clamp(offset_mm * per_side_ + 1, 0.0, static_cast<double>(count - 1)));
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

  Vec3 origin_, scale_;
  double error_mm_;  // more than that of a distance in single precision
  double side_mm_, per_side_;
  // A border of empty columns all around saves the question whether there is one.
  std::size_t width_, depth_;
  std::vector<Newest> newest_;  // of each column
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
    Level& level = levels_[LevelOf(point.spacing_mm)];
    level.least_mm = std::min<double>(level.least_mm, point.spacing_mm);
    level.columns.Add(point.p_mm, point.spacing_mm);
  }
  bool IsTooNear(const WeldPoint& point) const;

 private:
  struct Level {
    double reach_mm;  ///< at least the spacings of its points
    double least_mm;  ///< at most these
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
