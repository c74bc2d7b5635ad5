#pragma once

// Points by their places in x and y, for the check whether one is too near to any.

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::discretize {

/// More than rounding takes from a reach.
inline constexpr double kReachAllowance = 1 + 1e-9;

struct ThinningPoint {
  Vec3 p_mm;
  std::uint32_t source;
  float spacing_mm;
};

/// A grid of columns in x and y, each with its points from the newest down. Points are
/// added in rising height, along a given direction, so the points near a place at their
/// upper end are at the beginning of a few columns: the part of them that is read stays
/// in the cache.
///
/// A column is as wide as two reaches, so all points that can be too near to a point are
/// in four columns. The newest eight points of a column are also stored in single
/// precision next to one another. They decide in a few instructions, without a branch,
/// that most candidates are too near, and that most others are not.
class Columns {
 public:
  /// For points within the bounds and searches that reach `reach_mm` or a little farther,
  /// with heights divided by height_ratio; the columns are wider when `point_count`
  /// points do not justify as many.
  Columns(const Box3& bounds, double reach_mm, double height_ratio,
          std::size_t point_count, const Vec3& rise);

  bool empty() const { return entries_.empty(); }
  void Add(const Vec3& p_mm, float spacing_mm);

  /// The result of the fast check of a point: another is nearer than near_mm, or none is
  /// nearer than far_mm (at most reach_mm), heights divided by height_ratio, by more than
  /// the rounding error. by_own: the point's own spacing is used where it is larger.
  enum class Hasty : std::uint8_t { kNear, kFar, kUnsure };
  struct Distances {
    double near_mm, far_mm;
    bool by_own;
  };

  /// Moves the points that are not too near to any other to the front and returns their
  /// number. is_too_near(point, result of the fast check) is called unless that result is
  /// kNear.
  template <typename IsTooNear>
  std::size_t KeepFar(std::span<ThinningPoint> points, const Distances& distances,
                      const IsTooNear& is_too_near) const {
    std::array<Hasty, kMaxAtOnce> answers;
    std::size_t kept = 0;
    for (std::size_t begin = 0; begin < points.size(); begin += kMaxAtOnce) {
      const std::span some =
          points.subspan(begin, std::min(kMaxAtOnce, points.size() - begin));
      (this->*period_)(some, distances, answers.data());
      for (std::size_t i = 0; i < some.size(); ++i) {
        if (answers[i] == Hasty::kNear || is_too_near(some[i], answers[i])) continue;
        points[kept++] = some[i];
      }
    }
    return kept;
  }

  /// Whether too_near(q, spacing of q) is true of a point q whose x and y differ from
  /// those of p by less than reach_mm and which is not lower, along the rise, by
  /// reach_z_mm or more.
  template <typename TooNear>
  bool Any(const Vec3& p_mm, double reach_mm, double reach_z_mm,
           const TooNear& too_near) const {
    const double stop_mm = rise_.dot(p_mm) - reach_z_mm;
    const auto at = [this](double offset_mm, std::size_t count) {
      return static_cast<std::size_t>(
          std::clamp(offset_mm * per_side_ + 1, 0.0, static_cast<double>(count - 1)));
    };
    const double x = p_mm.x() - origin_.x(), y = p_mm.y() - origin_.y();
    const std::size_t x_end = at(x + reach_mm, width_), y_end = at(y + reach_mm, depth_);
    for (std::size_t j = at(y - reach_mm, depth_); j <= y_end; ++j) {
      for (std::size_t i = at(x - reach_mm, width_); i <= x_end; ++i) {
        for (std::uint32_t in = newest_[j * width_ + i].entry; in != kNone;
             in = entries_[in].below) {
          const Entry& q = entries_[in];
          if (rise_.dot(q.p_mm) <= stop_mm) break;  // and all below it
          if (too_near(q.p_mm, q.spacing_mm)) return true;
        }
      }
    }
    return false;
  }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  static constexpr std::size_t kNewest = 8;
  static constexpr std::size_t kMaxAtOnce = 64;

  struct Entry {
    Vec3 p_mm;
    std::uint32_t below;  ///< in the same column
    float spacing_mm;
  };
  /// Of a column; from its lower corner, heights divided by height_ratio.
  struct alignas(64) Newest {
    float x[kNewest], y[kNewest], z[kNewest];
    float older_height;   ///< all that are not among them are no higher, along the rise
    std::uint32_t entry;  ///< the last one
    std::uint32_t next_lane;
  };
  /// The search of a point's own column, of the nearer one beside it and of the two
  /// behind them. The point is x, y away from the corner of its own column, and other_x,
  /// other_y from the corner of theirs.
  struct Question {
    float x, other_x, y, other_y, z;
    float near_square, far_square, low_height;
    std::array<std::uint32_t, 4> columns;
  };
  static Hasty AnswerTo(const Question& q, float min_square, float older_height) {
    if (min_square < q.near_square) return Hasty::kNear;
    const bool unsure = min_square < q.far_square || older_height >= q.low_height;
    return unsure ? Hasty::kUnsure : Hasty::kFar;
  }
  using QueryFunction = void (Columns::*)(std::span<const ThinningPoint>,
                                          const Distances&, Hasty*) const;

  void Ask(std::span<const ThinningPoint> points, const Distances& distances,
           Question* questions) const;
  // At up to kMaxAtOnce points; with what every processor has, and with AVX2.
  void QueryByFour(std::span<const ThinningPoint> points, const Distances& distances,
                   Hasty* answers) const;
  void QueryByEight(std::span<const ThinningPoint> points, const Distances& distances,
                    Hasty* answers) const;
  static QueryFunction FastestQuery();

  Vec3 origin_, rise_;
  double flatten_;
  double side_mm_, per_side_;
  double error_mm_;  // more than that of a distance in single precision
  // A border of empty columns all around makes range checks unnecessary.
  std::size_t width_, depth_;
  QueryFunction period_ = FastestQuery();
  std::vector<Newest> newest_;  // of each column
  std::vector<Entry> entries_;
};

}  // namespace intaglio::discretize
