#include "engrave/proof/glass_comparison.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <deque>
#include <limits>
#include <numeric>
#include <optional>

#include "engrave/core/check.h"
#include "engrave/proof/point_tree.h"

namespace intaglio::proof {
namespace {

constexpr double kUmPerMm = 1000;

// Sums over the matched cracks, in mm^2 until the end.
struct ErrorSums {
  Vec3 squares = Vec3::Zero();
  double max_square = 0;
  std::uint64_t count = 0;

  void Add(const Vec3& error_mm) {
    squares += error_mm.cwiseAbs2();
    max_square = std::max(max_square, error_mm.squaredNorm());
    ++count;
  }
  AxisErrors Finish() const {
    if (count == 0) return {};
    const double n = static_cast<double>(count);
    return {std::sqrt(squares.sum() / n) * kUmPerMm, std::sqrt(max_square) * kUmPerMm,
            (squares / n).cwiseSqrt() * kUmPerMm};
  }
};

/// The points of a plan that are made in one channel, and where to find the nearest.
class ChannelPlan {
 public:
  ChannelPlan(const PointList& plan_mm, std::span<const ChannelMask> masks,
              ChannelMask channel)
      : index_of_(IndicesIn(masks, channel)),
        points_mm_(Picked(plan_mm, index_of_)),
        tree_(points_mm_),
        cracks_(index_of_.size(), 0) {}

  /// By place in the plan: the point that the crack belongs to.
  std::optional<std::uint32_t> Take(const Vec3& at_mm, double match_radius_mm) {
    if (points_mm_.empty()) return std::nullopt;
    const PointTree::Neighbour nearest = tree_.Nearest(at_mm);
    if (!(nearest.square < match_radius_mm * match_radius_mm)) return std::nullopt;
    ++cracks_[nearest.index];
    return index_of_[nearest.index];
  }

  void CountInto(ChannelGlass& glass, std::vector<std::uint32_t>& smallest,
                 std::vector<std::uint32_t>& largest) const {
    glass.planned_count = cracks_.size();
    for (std::size_t i = 0; i < cracks_.size(); ++i) {
      const std::uint32_t count = cracks_[i];
      ++(count == 0   ? glass.empty_count
         : count == 1 ? glass.made_count
                      : glass.doubled_count);
      smallest[index_of_[i]] = std::min(smallest[index_of_[i]], count);
      largest[index_of_[i]] = std::max(largest[index_of_[i]], count);
    }
  }

 private:
  static std::vector<std::uint32_t> IndicesIn(std::span<const ChannelMask> masks,
                                              ChannelMask channel) {
    std::vector<std::uint32_t> indices;
    for (std::uint32_t i = 0; i < masks.size(); ++i) {
      if (ShareChannel(masks[i], channel)) indices.push_back(i);
    }
    return indices;
  }
  static PointList Picked(const PointList& plan_mm,
                          const std::vector<std::uint32_t>& indices) {
    PointList picked;
    for (const std::uint32_t i : indices) picked.push_back(plan_mm[i]);
    return picked;
  }

  std::vector<std::uint32_t> index_of_;
  PointList points_mm_;
  PointTree tree_;
  std::vector<std::uint32_t> cracks_;
};

std::vector<std::uint32_t> ByTick(const std::vector<Crack>& cracks) {
  std::vector<std::uint32_t> by_tick(cracks.size());
  std::iota(by_tick.begin(), by_tick.end(), 0);
  std::stable_sort(by_tick.begin(), by_tick.end(), [&](std::uint32_t a, std::uint32_t b) {
    return cracks[a].tick < cracks[b].tick;
  });
  return by_tick;
}

void CountPoints(const std::vector<std::uint32_t>& largest, GlassComparison& result) {
  for (std::size_t i = 0; i < largest.size(); ++i) {
    ++(largest[i] > 1                   ? result.doubled_count
       : result.cracks_of_point[i] == 0 ? result.empty_count
                                        : result.made_count);
  }
}

}  // namespace

GlassComparison CompareGlass(const PointList& plan_mm, const std::vector<Crack>& cracks,
                             double match_radius_mm) {
  return CompareGlass(plan_mm, std::vector<ChannelMask>(plan_mm.size(), 1), cracks,
                      match_radius_mm);
}

GlassComparison CompareGlass(const PointList& plan_mm, std::span<const ChannelMask> masks,
                             const std::vector<Crack>& cracks, double match_radius_mm) {
  Require(match_radius_mm > 0, "match_radius_mm must be positive, is {}",
          match_radius_mm);
  Require(masks.size() == plan_mm.size(), "{} points have {} masks", plan_mm.size(),
          masks.size());
  GlassComparison result;
  result.planned_count = plan_mm.size();
  const std::vector<std::uint32_t> by_tick = ByTick(cracks);
  if (!by_tick.empty()) {
    result.first_tick = cracks[by_tick.front()].tick;
    result.last_tick = cracks[by_tick.back()].tick;
  }
  std::deque<ChannelPlan> plans;
  for (int i = 0; i < kMaxChannels; ++i) {
    plans.emplace_back(plan_mm, masks, static_cast<ChannelMask>(1 << i));
  }
  ErrorSums sums;
  std::vector<bool> seen(plan_mm.size(), false);
  for (const std::uint32_t index : by_tick) {
    const Crack& crack = cracks[index];
    const auto channel = static_cast<std::size_t>(std::countr_zero(crack.channel));
    Require(channel < plans.size(), "crack {} is in no channel", index);
    const auto point = plans[channel].Take(crack.position_mm, match_radius_mm);
    if (!point) {
      ++result.stray_count;
      ++result.channels[channel].stray_count;
      continue;
    }
    if (!seen[*point]) result.made_order.push_back(*point);
    seen[*point] = true;
    sums.Add(crack.position_mm - plan_mm[*point]);
  }
  result.cracks_of_point.assign(plan_mm.size(),
                                std::numeric_limits<std::uint32_t>::max());
  std::vector<std::uint32_t> largest(plan_mm.size(), 0);
  for (std::size_t i = 0; i < plans.size(); ++i) {
    plans[i].CountInto(result.channels[i], result.cracks_of_point, largest);
  }
  CountPoints(largest, result);
  result.errors = sums.Finish();
  return result;
}

double MinSpacing(const PointList& points_mm, std::span<const ChannelMask> masks) {
  // No copy by channel is needed.
  if (HaveOneMask(masks) && points_mm.size() > 1) return MinSpacing(points_mm);
  double min_mm = std::numeric_limits<double>::infinity();
  for (const ChannelMask channel : DistinctChannels(masks)) {
    PointList in_channel_mm;
    for (std::size_t i = 0; i < points_mm.size(); ++i) {
      if (ShareChannel(masks[i], channel)) in_channel_mm.push_back(points_mm[i]);
    }
    if (in_channel_mm.size() > 1) {
      min_mm = std::min(min_mm, MinSpacing(in_channel_mm));
    }
  }
  return min_mm;
}

double MinSpacing(const PointList& points_mm) {
  const PointTree tree(points_mm);
  double smallest = std::numeric_limits<double>::infinity();
  for (std::uint32_t i = 0; i < points_mm.size(); ++i) {
    smallest = std::min(smallest, tree.NearestOther(i).square);
  }
  return std::sqrt(smallest);
}

}  // namespace intaglio::proof
