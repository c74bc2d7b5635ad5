#include "engrave/sort/beam/channel_groups.h"

#include <algorithm>
#include <numeric>
#include <optional>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/sort/beam/remaining_points.h"

// A point is free when it shades no point that is left and shares a channel with it but
// is not free itself. A group is all points of one mask that are free: fewer would only
// leave some to a later group of the same mask. The lowest point left shades nothing, so
// a mask with a free point is always there, and the groups come to an end.
//
// Which mask is next: one that a group completes, since nothing can be gained by making
// the rest of it later; else the one of most free points, since it unlocks most.

namespace intaglio::sort {
namespace {

/// The points of one mask.
struct Share {
  ChannelMask mask;
  PointList points_mm;
  std::vector<std::uint32_t> index_of;  ///< in the whole cloud
  std::vector<std::uint32_t> left;      ///< of points_mm, in rising z
  std::optional<RemainingPoints> remaining;
  std::vector<std::uint32_t> free;  ///< of `left`, in rising z
  bool free_is_known = false;
};

class Groups {
 public:
  Groups(const PointList& points_mm, std::span<const ChannelMask> masks,
         const BeamCone& cone)
      : cone_(cone) {
    const std::vector<ChannelMask> distinct = DistinctMasks(masks);
    shares_.resize(distinct.size());
    for (std::size_t i = 0; i < distinct.size(); ++i) shares_[i].mask = distinct[i];
    for (std::uint32_t i = 0; i < points_mm.size(); ++i) {
      const auto at = std::lower_bound(distinct.begin(), distinct.end(), masks[i]);
      Share& share = shares_[static_cast<std::size_t>(at - distinct.begin())];
      share.points_mm.push_back(points_mm[i]);
      share.index_of.push_back(i);
    }
    for (Share& share : shares_) {
      const PointList& points = share.points_mm;
      share.left.resize(points.size());
      std::iota(share.left.begin(), share.left.end(), 0U);
      std::stable_sort(share.left.begin(), share.left.end(),
                       [&](std::uint32_t a, std::uint32_t b) {
                         return points[a].z() < points[b].z();
                       });
      share.remaining.emplace(points, share.left, 1);
    }
  }

  /// Empty when none is left.
  std::vector<std::uint32_t> TakeNext() {
    Share* next = nullptr;
    for (Share& share : shares_) {
      if (share.left.empty()) continue;
      if (!share.free_is_known) FindFree(share);
      if (next == nullptr || IsBetter(share, *next)) next = &share;
    }
    if (next == nullptr) return {};
    Require(!next->free.empty(), "no point of {} masks is free", shares_.size());
    return Take(*next);
  }

 private:
  static bool IsBetter(const Share& a, const Share& b) {
    const auto key = [](const Share& share) {
      return std::pair(share.free.size() == share.left.size(), share.free.size());
    };
    return key(a) > key(b);
  }

  void FindFree(Share& share) const {
    share.free.clear();
    share.free_is_known = true;
    RemainingPoints own = *share.remaining;
    for (const std::uint32_t point : share.left) {
      const Vec3& at_mm = share.points_mm[point];
      // From below: what is left of its own and lower is not free.
      if (own.Shades(at_mm, cone_) || ShadesOthers(share, at_mm)) continue;
      own.Take(point);
      share.free.push_back(point);
    }
  }

  bool ShadesOthers(const Share& share, const Vec3& at_mm) const {
    return std::any_of(shares_.begin(), shares_.end(), [&](const Share& other) {
      return &other != &share && ShareChannel(other.mask, share.mask) &&
             !other.left.empty() && other.remaining->Shades(at_mm, cone_);
    });
  }

  std::vector<std::uint32_t> Take(Share& share) {
    std::vector<std::uint32_t> group;
    for (const std::uint32_t point : share.free) {
      share.remaining->Take(point);
      group.push_back(share.index_of[point]);
    }
    std::erase_if(share.left, [&share](std::uint32_t point) {
      return !share.remaining->IsLeft(point);
    });
    for (Share& other : shares_) {
      if (ShareChannel(other.mask, share.mask)) other.free_is_known = false;
    }
    return group;
  }

  BeamCone cone_;
  std::vector<Share> shares_;
};

}  // namespace

std::vector<std::vector<std::uint32_t>> GroupByChannels(
    const PointList& points_mm, std::span<const ChannelMask> masks, const BeamCone& cone,
    const ProgressSink& progress) {
  RequireUsable(cone);
  Require(masks.size() == points_mm.size(), "{} points have {} masks", points_mm.size(),
          masks.size());
  Groups all(points_mm, masks, cone);
  std::vector<std::vector<std::uint32_t>> groups;
  for (auto group = all.TakeNext(); !group.empty(); group = all.TakeNext()) {
    if (progress && !progress(0, points_mm.size())) return {};
    groups.push_back(std::move(group));
  }
  return groups;
}

}  // namespace intaglio::sort
