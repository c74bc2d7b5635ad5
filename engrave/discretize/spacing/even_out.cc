#include "engrave/discretize/spacing/even_out.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <tuple>
#include <unordered_map>
#include <vector>

#include "engrave/core/channels.h"

// A point moves to the candidate where it is repelled the least by its neighbours, and
// where no rule is broken. A neighbour at d spacings counts (kRange - d)^2: the sum is
// the smallest in the middle of a gap, and with a range of less than two rows a row gives
// half of a gap to the next one. The rows move one after another, from the seam down, so
// that a sweep takes the gap through all of them.

namespace intaglio::discretize {
namespace {

constexpr double kRange = 1.6;     // of the repulsion, in spacings
constexpr double kStep = 0.45;     // a move, in spacings
constexpr int kSweeps = 2;         // a third one moves hardly a point
constexpr double kBetter = 0.999;  // of the repulsion, for a move to be worth it

/// Numbers of points by the cubes of a grid, in buckets: a bucket may hold several cubes,
/// so a number may be visited twice, and one that is not near.
class Cubes {
 public:
  Cubes(double side_mm, std::size_t count)
      : per_side_(1 / side_mm), mask_(std::bit_ceil(count / 2 + 16) - 1) {
    buckets_.resize(mask_ + 1);
  }

  void Add(const Vec3& p_mm, std::uint32_t i) {
    buckets_[BucketOf(CubeOf(p_mm))].push_back(i);
  }
  void Remove(const Vec3& p_mm, std::uint32_t i) {
    std::erase(buckets_[BucketOf(CubeOf(p_mm))], i);
  }
  template <typename Visit>
  void ForEachNear(const Vec3& p_mm, double reach_mm, const Visit& visit) const {
    const Cube low = CubeOf(p_mm.array() - reach_mm),
               high = CubeOf(p_mm.array() + reach_mm);
    for (std::int64_t z = low.z(); z <= high.z(); ++z) {
      for (std::int64_t y = low.y(); y <= high.y(); ++y) {
        for (std::int64_t x = low.x(); x <= high.x(); ++x) {
          for (const std::uint32_t i : buckets_[BucketOf({x, y, z})]) visit(i);
        }
      }
    }
  }

 private:
  using Cube = Eigen::Matrix<std::int64_t, 3, 1>;
  Cube CubeOf(const Vec3& p_mm) const {
    return (p_mm * per_side_).array().floor().cast<std::int64_t>();
  }
  std::size_t BucketOf(const Cube& cube) const {
    const auto part = [&](int axis) { return static_cast<std::uint64_t>(cube[axis]); };
    std::uint64_t key = part(0) * 0x9e3779b97f4a7c15U + part(1) * 0xc2b2ae3d27d4eb4fU +
                        part(2) * 0x165667b19e3779f9U;
    key ^= key >> 29;
    return static_cast<std::size_t>(key) & mask_;
  }

  double per_side_;
  std::size_t mask_;
  std::vector<std::vector<std::uint32_t>> buckets_;
};

class Mover {
 public:
  Mover(const SpacedCloud& candidates, const SpacedCloud& fixed, double from_mm,
        double reach_mm, const ThinningOptions& options, SpacedCloud& kept)
      : candidates_(candidates),
        from_mm_(from_mm),
        options_(options),
        kept_(kept),
        reach_mm_(reach_mm),
        point_cubes_(reach_mm_, kept.size()),
        candidate_cubes_(0.5 * reach_mm_, candidates.size() / 8) {
    const double margin_mm = (1 + kRange + kStep) * reach_mm_;
    for (std::uint32_t i = 0; i < candidates.size(); ++i) {
      const double height_mm = HeightOf(candidates.points_mm[i]);
      if (height_mm >= from_mm) candidate_cubes_.Add(candidates.points_mm[i], i);
    }
    for (std::uint32_t i = 0; i < kept.size(); ++i) {
      const double height_mm = HeightOf(kept.points_mm[i]);
      if (height_mm < from_mm - margin_mm) continue;
      if (height_mm >= from_mm && kept.spacing_mm[i] > 0) movable_.push_back(i);
      Include(kept, i);
      number_of_.emplace(i, static_cast<std::uint32_t>(points_.size() - 1));
    }
    for (std::uint32_t i = 0; i < fixed.size(); ++i) {
      if (HeightOf(fixed.points_mm[i]) >= from_mm - margin_mm) Include(fixed, i);
    }
  }

  void Run() {
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      std::sort(movable_.begin(), movable_.end(), [&](std::uint32_t a, std::uint32_t b) {
        const auto key = [&](std::uint32_t i) {
          const Vec3& p = kept_.points_mm[i];
          return std::tuple(-HeightOf(p), p.y(), p.x(), i);
        };
        return key(a) < key(b);
      });
      for (const std::uint32_t i : movable_) Move(i);
    }
    AddWhereThereIsRoom();
  }

 private:
  double HeightOf(const Vec3& p_mm) const { return options_.rise.dot(p_mm); }
  ChannelMask MaskOf(std::uint32_t source) const {
    const auto& masks = options_.channels_of_source;
    return masks.empty() ? kAnyChannel : masks.at(source);
  }
  void Include(const SpacedCloud& cloud, std::uint32_t i) {
    point_cubes_.Add(cloud.points_mm[i], static_cast<std::uint32_t>(points_.size()));
    points_.Add(cloud.points_mm[i], cloud.source[i], cloud.spacing_mm[i]);
  }

  void Move(std::uint32_t i) {
    const std::uint32_t self = number_of_.at(i);
    const Vec3 p_mm = points_.points_mm[self];
    const std::uint32_t source = points_.source[self];
    const double spacing_mm = points_.spacing_mm[self], step_mm = kStep * spacing_mm;
    CollectTargets(self, step_mm);
    CollectNeighbours(self, step_mm);
    double smallest = *RepulsionAt(p_mm, source, points_.spacing_mm[self]) * kBetter;
    std::optional<std::uint32_t> best;
    for (const std::uint32_t c : targets_) {
      const auto repulsion =
          RepulsionAt(candidates_.points_mm[c], source, candidates_.spacing_mm[c]);
      if (!repulsion || *repulsion > smallest) continue;
      if (*repulsion == smallest && best && !IsBefore(c, *best)) continue;
      smallest = *repulsion;
      best = c;
    }
    if (!best) return;
    point_cubes_.Remove(p_mm, self);
    points_.points_mm[self] = kept_.points_mm[i] = candidates_.points_mm[*best];
    points_.spacing_mm[self] = kept_.spacing_mm[i] = candidates_.spacing_mm[*best];
    point_cubes_.Add(points_.points_mm[self], self);
  }
  /// So that the result does not depend on the candidates' sequence.
  bool IsBefore(std::uint32_t a, std::uint32_t b) const {
    const auto key = [&](std::uint32_t c) {
      const Vec3& p = candidates_.points_mm[c];
      return std::tuple(p.z(), p.y(), p.x(), candidates_.spacing_mm[c]);
    };
    return key(a) < key(b);
  }

  /// The candidates to which the point may move.
  void CollectTargets(std::uint32_t self, double step_mm) {
    targets_.clear();
    const Vec3& p_mm = points_.points_mm[self];
    candidate_cubes_.ForEachNear(p_mm, step_mm, [&](std::uint32_t c) {
      const double square = (candidates_.points_mm[c] - p_mm).squaredNorm();
      if (square > step_mm * step_mm || candidates_.source[c] != points_.source[self]) {
        return;
      }
      targets_.push_back(c);
    });
  }

  /// Those that can repel the point, or break a rule, at any target. Sorted: sums depend
  /// on the sequence in their last bits.
  void CollectNeighbours(std::uint32_t self, double step_mm) {
    neighbours_.clear();
    const Vec3& p_mm = points_.points_mm[self];
    float largest_mm = points_.spacing_mm[self];
    for (const std::uint32_t c : targets_) {
      largest_mm = std::max(largest_mm, candidates_.spacing_mm[c]);
    }
    const double block_mm = options_.min_spacing_mm * options_.height_ratio;
    point_cubes_.ForEachNear(p_mm, kRange * reach_mm_ + step_mm, [&](std::uint32_t j) {
      const double own_mm = kRange * std::max(largest_mm, points_.spacing_mm[j]);
      const double far_mm = std::max(block_mm, own_mm) + step_mm;
      if (j == self || (points_.points_mm[j] - p_mm).squaredNorm() > far_mm * far_mm ||
          !ShareChannel(MaskOf(points_.source[j]), MaskOf(points_.source[self]))) {
        return;
      }
      neighbours_.push_back(j);
    });
    std::sort(neighbours_.begin(), neighbours_.end());
    neighbours_.erase(std::unique(neighbours_.begin(), neighbours_.end()),
                      neighbours_.end());
  }

  /// Nothing where a rule of thinning.h forbids a point. Only points of the same source
  /// repel.
  std::optional<double> RepulsionAt(const Vec3& p_mm, std::uint32_t source,
                                    float spacing_mm) const {
    const double min_square = options_.min_spacing_mm * options_.min_spacing_mm;
    double sum = 0;
    for (const std::uint32_t j : neighbours_) {
      const Vec3& q = points_.points_mm[j];
      const double dx = p_mm.x() - q.x(), dy = p_mm.y() - q.y(), dz = p_mm.z() - q.z();
      const double flat = dz / options_.height_ratio;
      if (dx * dx + dy * dy + flat * flat < min_square) return std::nullopt;
      if (points_.source[j] != source) continue;
      const double square = dx * dx + dy * dy + dz * dz;
      const double s = std::max(spacing_mm, points_.spacing_mm[j]);
      if (square < s * s) return std::nullopt;
      if (square >= kRange * kRange * s * s) continue;
      const double t = kRange - std::sqrt(square) / s;
      sum += t * t;
    }
    return sum;
  }

  /// A point that has moved may leave room up to a reach and a step away.
  void AddWhereThereIsRoom() {
    SpacedCloud open;
    const double low_mm = from_mm_ - (1 + kStep) * reach_mm_;
    for (std::uint32_t i = 0; i < candidates_.size(); ++i) {
      if (HeightOf(candidates_.points_mm[i]) < low_mm) continue;
      open.Add(candidates_.points_mm[i], candidates_.source[i],
               candidates_.spacing_mm[i]);
    }
    const SpacedCloud added = Thin(open, options_, points_);
    for (std::size_t i = 0; i < added.size(); ++i) {
      kept_.Add(added.points_mm[i], added.source[i], added.spacing_mm[i]);
    }
  }

  const SpacedCloud& candidates_;
  double from_mm_;
  const ThinningOptions& options_;
  SpacedCloud& kept_;
  double reach_mm_;
  SpacedCloud points_;  // those of the neighbourhood, at their present places
  std::unordered_map<std::uint32_t, std::uint32_t> number_of_;  // in points_, of kept_
  std::vector<std::uint32_t> movable_, targets_, neighbours_;
  Cubes point_cubes_, candidate_cubes_;
};

}  // namespace

void EvenOut(const SpacedCloud& candidates, const SpacedCloud& fixed, double from_mm,
             double reach_mm, const ThinningOptions& options, SpacedCloud& kept) {
  if (candidates.size() == 0 || kept.size() == 0) return;
  Mover(candidates, fixed, from_mm, reach_mm, options, kept).Run();
}

}  // namespace intaglio::discretize
