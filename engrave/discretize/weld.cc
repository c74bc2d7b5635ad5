#include "engrave/discretize/weld.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <vector>

#include "engrave/core/check.h"

// The points are taken from the lowest up, and one is kept unless it is too near to one
// kept before. Those lie at most one spacing below, so a column of a grid in x and y,
// seen from its newest point down, is left as soon as a point is a whole spacing lower.

namespace intaglio::discretize {
namespace {

// A grid in x and y: at most this many columns an axis, so that a tiny spacing in a large
// block takes no memory that the points do not justify.
constexpr double kMaxColumns = 2048;
constexpr std::uint32_t kNone = 0xffffffff;

class Columns {
 public:
  Columns(const Box3& bounds, double spacing_mm, std::size_t point_count)
      : origin_(bounds.min_mm.head<2>()), next_(point_count, kNone) {
    const Vec3 size = bounds.size_mm();
    side_mm_ = std::max({spacing_mm, size.x() / kMaxColumns, size.y() / kMaxColumns});
    count_x_ = static_cast<int>(size.x() / side_mm_) + 1;
    count_y_ = static_cast<int>(size.y() / side_mm_) + 1;
    newest_.assign(
        static_cast<std::size_t>(count_x_) * static_cast<std::size_t>(count_y_), kNone);
  }

  int ColumnX(double x_mm) const {
    return static_cast<int>((x_mm - origin_.x()) / side_mm_);
  }
  int ColumnY(double y_mm) const {
    return static_cast<int>((y_mm - origin_.y()) / side_mm_);
  }

  void Push(int cx, int cy, std::uint32_t kept) {
    std::uint32_t& newest = newest_[Index(cx, cy)];
    next_[kept] = newest;
    newest = kept;
  }

  /// True when `conflicts` holds for a point of the column; `too_low` ends the look down.
  template <typename Conflicts, typename TooLow>
  bool AnyInColumn(int cx, int cy, Conflicts&& conflicts, TooLow&& too_low) const {
    if (cx < 0 || cy < 0 || cx >= count_x_ || cy >= count_y_) return false;
    for (std::uint32_t at = newest_[Index(cx, cy)]; at != kNone && !too_low(at);
         at = next_[at]) {
      if (conflicts(at)) return true;
    }
    return false;
  }

 private:
  std::size_t Index(int cx, int cy) const {
    return static_cast<std::size_t>(cy) * static_cast<std::size_t>(count_x_) +
           static_cast<std::size_t>(cx);
  }
  Vec2 origin_;
  double side_mm_ = 1;
  int count_x_ = 1, count_y_ = 1;
  std::vector<std::uint32_t> newest_;  // of each column, index of a kept point
  std::vector<std::uint32_t> next_;    // the one below it in its column
};

std::vector<std::uint32_t> FromTheLowest(const PointCloud& cloud) {
  std::vector<std::uint32_t> order(cloud.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const Vec3& p = cloud.points_mm[a];
    const Vec3& q = cloud.points_mm[b];
    return std::tuple(p.z(), p.y(), p.x(), cloud.source[a]) <
           std::tuple(q.z(), q.y(), q.x(), cloud.source[b]);
  });
  return order;
}

}  // namespace

PointCloud WeldToSpacing(const PointCloud& cloud, double min_spacing_mm) {
  Require(min_spacing_mm > 0, "min_spacing_mm must be positive, is {}", min_spacing_mm);
  Require(cloud.size() < kNone, "a cloud of {} points is too large", cloud.size());
  PointCloud kept;
  Box3 bounds;
  for (const Vec3& p : cloud.points_mm) bounds.Extend(p);
  if (bounds.empty()) return kept;
  const double least_square = min_spacing_mm * min_spacing_mm;
  Columns columns(bounds, min_spacing_mm, cloud.size());
  for (const std::uint32_t index : FromTheLowest(cloud)) {
    const Vec3& p = cloud.points_mm[index];
    const int cx = columns.ColumnX(p.x()), cy = columns.ColumnY(p.y());
    const auto conflicts = [&](std::uint32_t at) {
      return (kept.points_mm[at] - p).squaredNorm() < least_square;
    };
    // Points in a column were kept in the order of their z.
    const auto too_low = [&](std::uint32_t at) {
      const double dz = p.z() - kept.points_mm[at].z();
      return dz * dz >= least_square;
    };
    bool free = true;
    for (int dy = -1; dy <= 1 && free; ++dy) {
      for (int dx = -1; dx <= 1 && free; ++dx) {
        free = !columns.AnyInColumn(cx + dx, cy + dy, conflicts, too_low);
      }
    }
    if (!free) continue;
    columns.Push(cx, cy, static_cast<std::uint32_t>(kept.size()));
    kept.Add(p, cloud.source[index]);
  }
  return kept;
}

}  // namespace intaglio::discretize
