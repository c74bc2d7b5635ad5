#include "engrave/sort/ticks_bound.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/sort/near/cell_grid.h"

// Lengths are in units of A T^2, of each axis its own; there (1) and (2) are
//   |d| <= speed n + 2 e,   |d2 - d1 n2 / n1| <= n2 (n1 + n2) / 2 + 2 e (1 + n2 / n1).
// So the third point lies in a box around the mirror image of the first one, drawn out
// by n2 / n1. A way backwards is one, too: n1 <= n2 is enough.

namespace intaglio::sort {
namespace {

/// c(p) is looked for up to this; what is beyond counts as one more.
constexpr int kMaxSum = 16;
/// Points looked at for one c(p).
constexpr int kMaxVisits = 800;
/// The limits are taken as this much greater, for rounding.
constexpr double kLooserLimits = 1 + 1e-6;
constexpr std::size_t kPointsAtOnce = 4096;

struct Around {
  Vec3 low, high;
  bool Contains(const Vec3& p) const {
    return (p.array() >= low.array()).all() && (p.array() <= high.array()).all();
  }
};

Scaled Rounded(const Vec3& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()),
          static_cast<float>(p.z())};
}

std::vector<Scaled> Rounded(const std::vector<Vec3>& points) {
  std::vector<Scaled> rounded;
  rounded.reserve(points.size());
  for (const Vec3& p : points) rounded.push_back(Rounded(p));
  return rounded;
}

/// In units of A T^2, in the place of the given ones.
std::vector<Vec3> InUnits(PointList points_mm, const Vec3& unit_mm) {
  const Vec3 origin_mm = points_mm.front();
  for (Vec3& p : points_mm) p = (p - origin_mm).cwiseQuotient(unit_mm);
  return points_mm;
}

Vec3 UnitOf(const TicksBoundOptions& options) {
  const motion::Limits& limits = options.limits;
  return kLooserLimits / (options.rate_hz * options.rate_hz) *
         limits.max_acceleration_mm_s2.cwiseMin(limits.max_acceleration_norm_mm_s2);
}

/// A cell's side so that few points are in one, of a cloud spread over its longest two
/// extents, as surfaces are: these may lie in folds.
float CellOf(const std::vector<Vec3>& points) {
  Box3 box;
  for (const Vec3& p : points) box.Extend(p);
  Vec3 size = box.size_mm();
  std::sort(size.data(), size.data() + 3);
  const auto count = static_cast<double>(points.size());
  constexpr double kFolds = 2.5;
  return static_cast<float>(
      kFolds * std::max(std::sqrt(size[1] * size[2] / count), size[2] / count));
}

class ShortestPasses {
 public:
  ShortestPasses(PointList points_mm, const TicksBoundOptions& options)
      : points_(InUnits(std::move(points_mm), UnitOf(options))),
        grid_(Rounded(points_), CellOf(points_)) {
    const motion::Limits& limits = options.limits;
    const Vec3 unit = UnitOf(options);
    speed_ = (kLooserLimits / options.rate_hz *
              limits.max_speed_mm_s.cwiseMin(limits.max_speed_norm_mm_s))
                 .cwiseQuotient(unit);
    shift_ = 2 * options.tolerance_mm * unit.cwiseInverse();
  }

  /// c(p), or as much of it as was proved.
  int SumAt(std::uint32_t p) const {
    int visits = 0;
    for (int sum = 2; sum <= kMaxSum; ++sum) {
      if (CanPass(p, sum, visits) || visits > kMaxVisits) return sum;
    }
    return kMaxSum + 1;
  }

 private:
  template <typename Take>
  bool ForEachIn(const Around& box, Take&& take) const {
    // Rounding keeps the order, so no point of the box is missed.
    return grid_.ForEachInCells(
        grid_.CellOf(Rounded(box.low)), grid_.CellOf(Rounded(box.high)),
        [&](std::uint32_t i) { return !box.Contains(points_[i]) || take(i); });
  }

  /// True, too, when there were too many visits to know.
  bool CanPass(std::uint32_t p, int sum, int& visits) const {
    if (sum % 2 == 0 && TwoAreNear(p, sum / 2)) return true;
    for (int first = 1; 2 * first <= sum; ++first) {
      if (CanPass(p, first, sum - first, visits)) return true;
    }
    return false;
  }

  /// Most points have two so near that no direction matters.
  bool TwoAreNear(std::uint32_t p, int ticks) const {
    const Vec3& here = points_[p];
    const Vec3 near =
        Vec3::Constant(0.5 * ticks * ticks).cwiseMin(ticks * speed_) + 0.5 * shift_;
    int found = 0;
    return !ForEachIn({here - near, here + near}, [&](std::uint32_t i) {
      found += i != p;
      return found < 2;
    });
  }

  bool CanPass(std::uint32_t p, int before, int after, int& visits) const {
    const Vec3& here = points_[p];
    const double ratio = static_cast<double>(after) / before;
    const Vec3 reach_before = before * speed_ + shift_;
    const Vec3 reach_after = after * speed_ + shift_;
    const Vec3 bend =
        Vec3::Constant(0.5 * after * (before + after)) + (1 + ratio) * shift_;
    return !ForEachIn({here - reach_before, here + reach_before}, [&](std::uint32_t q) {
      if (q == p) return true;
      if (++visits > kMaxVisits) return false;
      const Vec3 onwards = here + ratio * (here - points_[q]);
      const Around box{(onwards - bend).cwiseMax(here - reach_after),
                       (onwards + bend).cwiseMin(here + reach_after)};
      if ((box.low.array() > box.high.array()).any()) return true;
      return ForEachIn(box, [&](std::uint32_t r) {
        ++visits;
        return r == p || r == q;
      });
    });
  }

  std::vector<Vec3> points_;
  CellGrid grid_;
  Vec3 speed_, shift_;
};

struct Sums {
  std::uint64_t all = 0;
  int largest = 2, second = 2;

  void Add(int sum) {
    all += static_cast<std::uint64_t>(sum);
    AddExtreme(sum);
  }
  void Add(const Sums& part) {
    all += part.all;
    AddExtreme(part.largest);
    AddExtreme(part.second);
  }

 private:
  void AddExtreme(int sum) {
    second = std::max(second, std::min(sum, largest));
    largest = std::max(largest, sum);
  }
};

}  // namespace

std::uint64_t TicksBound(PointList points_mm, const TicksBoundOptions& options) {
  motion::RequireUsable(options.limits);
  Require(options.rate_hz > 0 && std::isfinite(options.rate_hz),
          "rate_hz must be positive, is {}", options.rate_hz);
  Require(options.tolerance_mm >= 0 && std::isfinite(options.tolerance_mm),
          "tolerance_mm must not be negative, is {}", options.tolerance_mm);
  const std::size_t count = points_mm.size();
  if (count < 2) return 0;
  const ShortestPasses passes(std::move(points_mm), options);
  std::vector<Sums> parts((count + kPointsAtOnce - 1) / kPointsAtOnce);
  RunEach(options.executor, parts.size(), [&](std::size_t part) {
    const std::size_t end = std::min(count, (part + 1) * kPointsAtOnce);
    for (std::size_t p = part * kPointsAtOnce; p < end; ++p) {
      parts[part].Add(passes.SumAt(static_cast<std::uint32_t>(p)));
    }
  });
  Sums total;
  for (const Sums& part : parts) total.Add(part);
  const auto ends = static_cast<std::uint64_t>(total.largest + total.second);
  return (total.all - ends + 2 + 1) / 2;
}

}  // namespace intaglio::sort
