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
constexpr std::size_t kPointsPerSearch = 8192;

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

/// The points of a plan that are made in one channel, and where to find the nearest. All
/// points of the plan, or none, are not copied.
class ChannelPlan {
 public:
  /// The plan must outlive it.
  ChannelPlan(const PointList& plan_mm, std::span<const ChannelMask> masks,
              ChannelMask channel) {
    const auto count = static_cast<std::size_t>(std::count_if(
        masks.begin(), masks.end(),
        [channel](ChannelMask mask) { return ShareChannel(mask, channel); }));
    const bool has_all = count == plan_mm.size();
    if (!has_all) Pick(plan_mm, masks, channel, count);
    tree_.emplace(has_all ? plan_mm : picked_mm_);
    cracks_.assign(count, 0);
  }

  /// By place in the plan: the point that the crack belongs to.
  std::optional<std::uint32_t> Take(const Vec3& at_mm, double match_radius_mm) {
    if (cracks_.empty()) return std::nullopt;
    const PointTree::Neighbour nearest = tree_->Nearest(at_mm);
    if (!(nearest.square < match_radius_mm * match_radius_mm)) return std::nullopt;
    ++cracks_[nearest.index];
    return IndexOf(nearest.index);
  }
  /// No crack is left to take.
  void EndSearch() { tree_.reset(); }

  void CountInto(ChannelGlass& glass, std::vector<std::uint32_t>& smallest,
                 std::vector<std::uint32_t>& largest) const {
    glass.planned_count = cracks_.size();
    for (std::uint32_t i = 0; i < cracks_.size(); ++i) {
      const std::uint32_t count = cracks_[i], index = IndexOf(i);
      ++(count == 0   ? glass.empty_count
         : count == 1 ? glass.made_count
                      : glass.doubled_count);
      smallest[index] = std::min(smallest[index], count);
      largest[index] = std::max(largest[index], count);
    }
  }

 private:
  std::uint32_t IndexOf(std::uint32_t i) const {
    return index_of_.empty() ? i : index_of_[i];
  }
  void Pick(const PointList& plan_mm, std::span<const ChannelMask> masks,
            ChannelMask channel, std::size_t count) {
    index_of_.reserve(count);
    picked_mm_.reserve(count);
    for (std::uint32_t i = 0; i < masks.size(); ++i) {
      if (!ShareChannel(masks[i], channel)) continue;
      index_of_.push_back(i);
      picked_mm_.push_back(plan_mm[i]);
    }
  }

  std::vector<std::uint32_t> index_of_;  // empty: all points
  PointList picked_mm_;
  std::optional<PointTree> tree_;
  std::vector<std::uint32_t> cracks_;
};

/// Empty: they are given in this order.
std::vector<std::uint32_t> ByTick(const std::vector<std::uint64_t>& ticks) {
  std::vector<std::uint32_t> by_tick;
  if (std::is_sorted(ticks.begin(), ticks.end())) return by_tick;
  by_tick.resize(ticks.size());
  std::iota(by_tick.begin(), by_tick.end(), 0);
  std::stable_sort(by_tick.begin(), by_tick.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return ticks[a] < ticks[b]; });
  return by_tick;
}

/// Stray cracks, made_order and errors of the result.
void MatchCracks(const PointList& plan_mm, const Cracks& cracks, double match_radius_mm,
                 std::deque<ChannelPlan>& plans, GlassComparison& result) {
  ErrorSums sums;
  std::vector<bool> seen(plan_mm.size(), false);
  result.made_order.reserve(plan_mm.size());
  const std::vector<std::uint32_t> by_tick = ByTick(cracks.ticks);
  for (std::uint32_t place = 0; place < cracks.size(); ++place) {
    const std::uint32_t index = by_tick.empty() ? place : by_tick[place];
    const auto channel =
        static_cast<std::size_t>(std::countr_zero(cracks.channels[index]));
    Require(channel < plans.size(), "crack {} is in no channel", index);
    const Vec3& at_mm = cracks.positions_mm[index];
    const auto point = plans[channel].Take(at_mm, match_radius_mm);
    if (!point) {
      ++result.stray_count;
      ++result.channels[channel].stray_count;
      continue;
    }
    if (!seen[*point]) result.made_order.push_back(*point);
    seen[*point] = true;
    sums.Add(at_mm - plan_mm[*point]);
  }
  result.errors = sums.Finish();
}

void CountPoints(const std::vector<std::uint32_t>& largest, GlassComparison& result) {
  for (std::size_t i = 0; i < largest.size(); ++i) {
    ++(largest[i] > 1                   ? result.doubled_count
       : result.cracks_of_point[i] == 0 ? result.empty_count
                                        : result.made_count);
  }
}

}  // namespace

GlassComparison CompareGlass(const PointList& plan_mm, const Cracks& cracks,
                             double match_radius_mm) {
  return CompareGlass(plan_mm, std::vector<ChannelMask>(plan_mm.size(), 1), cracks,
                      match_radius_mm);
}

GlassComparison CompareGlass(const PointList& plan_mm, std::span<const ChannelMask> masks,
                             const Cracks& cracks, double match_radius_mm) {
  Require(match_radius_mm > 0, "match_radius_mm must be positive, is {}",
          match_radius_mm);
  Require(masks.size() == plan_mm.size(), "{} points have {} masks", plan_mm.size(),
          masks.size());
  Require(cracks.ticks.size() == cracks.size() && cracks.channels.size() == cracks.size(),
          "{} cracks have {} ticks and {} channels", cracks.size(), cracks.ticks.size(),
          cracks.channels.size());
  GlassComparison result;
  result.planned_count = plan_mm.size();
  if (cracks.size() > 0) {
    const auto [first, last] =
        std::minmax_element(cracks.ticks.begin(), cracks.ticks.end());
    result.first_tick = *first;
    result.last_tick = *last;
  }
  std::deque<ChannelPlan> plans;
  for (int i = 0; i < kMaxChannels; ++i) {
    plans.emplace_back(plan_mm, masks, static_cast<ChannelMask>(1 << i));
  }
  MatchCracks(plan_mm, cracks, match_radius_mm, plans, result);
  for (ChannelPlan& plan : plans) plan.EndSearch();
  result.cracks_of_point.assign(plan_mm.size(),
                                std::numeric_limits<std::uint32_t>::max());
  std::vector<std::uint32_t> largest(plan_mm.size(), 0);
  for (std::size_t i = 0; i < plans.size(); ++i) {
    plans[i].CountInto(result.channels[i], result.cracks_of_point, largest);
  }
  CountPoints(largest, result);
  return result;
}

double MinSpacing(const PointList& points_mm, std::span<const ChannelMask> masks,
                  const Executor& executor) {
  // No copy by channel is needed.
  if (HaveOneMask(masks) && points_mm.size() > 1) return MinSpacing(points_mm, executor);
  double min_mm = std::numeric_limits<double>::infinity();
  for (const ChannelMask channel : DistinctChannels(masks)) {
    PointList in_channel_mm;
    for (std::size_t i = 0; i < points_mm.size(); ++i) {
      if (ShareChannel(masks[i], channel)) in_channel_mm.push_back(points_mm[i]);
    }
    if (in_channel_mm.size() > 1) {
      min_mm = std::min(min_mm, MinSpacing(in_channel_mm, executor));
    }
  }
  return min_mm;
}

double MinSpacing(const PointList& points_mm, const Executor& executor) {
  const PointTree tree(points_mm);
  const std::size_t count = points_mm.size();
  std::vector<double> smallest((count + kPointsPerSearch - 1) / kPointsPerSearch,
                               std::numeric_limits<double>::infinity());
  RunEach(executor, smallest.size(), [&](std::size_t task) {
    const std::size_t end = std::min(count, (task + 1) * kPointsPerSearch);
    double square = smallest[task];
    for (std::size_t i = task * kPointsPerSearch; i < end; ++i) {
      square = std::min(square, tree.NearestOther(static_cast<std::uint32_t>(i)).square);
    }
    smallest[task] = square;
  });
  double square = std::numeric_limits<double>::infinity();
  for (const double of_task : smallest) square = std::min(square, of_task);
  return std::sqrt(square);
}

}  // namespace intaglio::proof
