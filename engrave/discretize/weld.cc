#include "engrave/discretize/weld.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

#include "engrave/core/check.h"

// The points are taken from the lowest up, and one is kept unless it is too near to one
// kept before. Those lie at most one spacing below, so a column of a grid in x and y,
// seen from its newest point down, is left as soon as a point is a whole spacing lower.
// What is read is the uppermost spacing of the columns: it stays in the cache.
//
// Why this order: it makes the result independent of the input's, and a front that grows
// upward packs evenly. On the bunny filled at half the spacing the nearest distances vary
// by 5.4 % (coefficient of variation); visiting cell by cell instead costs 8 % of the
// points and varies by 6.2 %.

namespace intaglio::discretize {
namespace {

// Two points nearer than the spacing differ by less than a column's width even after the
// rounding of their column numbers.
constexpr double kColumnAllowance = 1 + 1e-9;
// Columns an axis, so that a tiny spacing in a large block takes no memory that the
// points do not justify.
constexpr double kMaxColumns = 2048;
constexpr std::uint32_t kNone = 0xffffffff;

struct Candidate {
  Vec3 p_mm;
  std::uint32_t source;

  bool operator<(const Candidate& other) const {
    if (p_mm.z() != other.p_mm.z()) return p_mm.z() < other.p_mm.z();
    if (p_mm.y() != other.p_mm.y()) return p_mm.y() < other.p_mm.y();
    if (p_mm.x() != other.p_mm.x()) return p_mm.x() < other.p_mm.x();
    return source < other.source;
  }
};

/// The cloud in the order of z, then y, then x, then source, a bucket of heights at a
/// time.
class FromTheLowest {
 public:
  FromTheLowest(const PointCloud& cloud, const Box3& bounds) : cloud_(cloud) {
    constexpr std::size_t kPointsPerBucket = 16, kMaxBuckets = std::size_t{1} << 17;
    const std::size_t buckets =
        std::clamp<std::size_t>(cloud.size() / kPointsPerBucket, 1, kMaxBuckets);
    const double low_mm = bounds.min_mm.z(), height_mm = bounds.size_mm().z();
    const double scale = height_mm > 0 ? static_cast<double>(buckets - 1) / height_mm : 0;
    const auto bucket_of = [&](const Vec3& p) {
      return std::min(buckets - 1, static_cast<std::size_t>((p.z() - low_mm) * scale));
    };
    begin_.assign(buckets + 1, 0);
    for (const Vec3& p : cloud.points_mm) ++begin_[bucket_of(p) + 1];
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    index_.resize(cloud.size());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (std::uint32_t i = 0; i < cloud.size(); ++i) {
      index_[next[bucket_of(cloud.points_mm[i])]++] = i;
    }
  }

  template <typename Visit>
  void ForEach(const Visit& visit) const {
    std::vector<Candidate> sorted;
    for (std::size_t bucket = 0; bucket + 1 < begin_.size(); ++bucket) {
      sorted.clear();
      for (std::uint32_t i = begin_[bucket]; i < begin_[bucket + 1]; ++i) {
        // + 0.0 turns -0.0 into 0.0: equal points are equal in their bits, too.
        sorted.push_back(
            {cloud_.points_mm[index_[i]].array() + 0.0, cloud_.source[index_[i]]});
      }
      std::sort(sorted.begin(), sorted.end());
      for (const Candidate& candidate : sorted) visit(candidate);
    }
  }

 private:
  const PointCloud& cloud_;
  std::vector<std::uint32_t> begin_;  // of each bucket in index_
  std::vector<std::uint32_t> index_;
};

class Columns {
 public:
  Columns(const Box3& bounds, double spacing_mm)
      : origin_(bounds.min_mm.head<2>()), least_square_(spacing_mm * spacing_mm) {
    const Vec3 size = bounds.size_mm();
    side_mm_ = std::max(
        {spacing_mm * kColumnAllowance, size.x() / kMaxColumns, size.y() / kMaxColumns});
    // A border of empty columns all around saves the question whether there is one.
    width_ = static_cast<std::size_t>(size.x() / side_mm_) + 3;
    const std::size_t depth = static_cast<std::size_t>(size.y() / side_mm_) + 3;
    newest_.assign(width_ * depth, kNone);
  }

  /// Keeps the point unless one kept before is nearer than the spacing. Points must come
  /// in rising z.
  bool Keep(const Vec3& p_mm) {
    const std::size_t own = ColumnOf(p_mm);
    const std::size_t w = width_;
    for (const std::size_t column : {own, own - 1, own + 1, own - w, own + w, own - w - 1,
                                     own - w + 1, own + w - 1, own + w + 1}) {
      if (IsTakenIn(column, p_mm)) return false;
    }
    kept_.push_back({p_mm, newest_[own]});
    newest_[own] = static_cast<std::uint32_t>(kept_.size() - 1);
    return true;
  }

 private:
  struct Kept {
    Vec3 p_mm;
    std::uint32_t below;  ///< in the same column
  };

  std::size_t ColumnOf(const Vec3& p_mm) const {
    const auto x = static_cast<std::size_t>((p_mm.x() - origin_.x()) / side_mm_);
    const auto y = static_cast<std::size_t>((p_mm.y() - origin_.y()) / side_mm_);
    return (y + 1) * width_ + x + 1;
  }

  bool IsTakenIn(std::size_t column, const Vec3& p_mm) const {
    for (std::uint32_t at = newest_[column]; at != kNone; at = kept_[at].below) {
      const Vec3 d = p_mm - kept_[at].p_mm;
      if (d.squaredNorm() < least_square_) return true;
      if (d.z() * d.z() >= least_square_) return false;  // and all below it
    }
    return false;
  }

  Vec2 origin_;
  double least_square_;
  double side_mm_ = 1;
  std::size_t width_ = 3;
  std::vector<std::uint32_t> newest_;  // of each column, in kept_
  std::vector<Kept> kept_;
};

}  // namespace

PointCloud WeldToSpacing(const PointCloud& cloud, double min_spacing_mm) {
  Require(min_spacing_mm > 0, "min_spacing_mm must be positive, is {}", min_spacing_mm);
  Require(cloud.size() < kNone, "a cloud of {} points is too large", cloud.size());
  PointCloud kept;
  Box3 bounds;
  for (const Vec3& p : cloud.points_mm) {
    Require(p.allFinite(), "a point to weld is not finite: {} {} {}", p.x(), p.y(),
            p.z());
    bounds.Extend(p);
  }
  if (bounds.empty()) return kept;
  Columns columns(bounds, min_spacing_mm);
  FromTheLowest(cloud, bounds).ForEach([&](const Candidate& candidate) {
    if (columns.Keep(candidate.p_mm)) kept.Add(candidate.p_mm, candidate.source);
  });
  return kept;
}

}  // namespace intaglio::discretize
