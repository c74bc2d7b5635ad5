// A k-d tree over the points as they were made; each node has the box around its points
// and the first of them to be made. For a point p, a subtree need not be searched if its
// first point was made after p, or if the part of its box above p lies outside the cone.
// It decides at once if its box lies entirely inside the cone and its first point was
// made before p.
//
// The cone widens upwards, so of a box its top face reaches farthest in: some point of
// the box is inside only if (distance of p to the box in XY, height of the top) is
// inside, and all are if (distance to the farthest corner, height of the bottom) is. Both
// are evaluated with the expression that is used for single points, and each of its
// operations is monotone in floating point as well; so the result is that of the brute
// force, bit for bit. Where the axis of the cone leans, the box moves aside with it: over
// the heights of the box the axis covers a stretch, by which the box counts as wider for
// the first test and as farther for the second; a hair's breadth is added to both for
// rounding, since the test of single points decides in the end.

#include "engrave/sort/shadow.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <vector>

#include "engrave/core/check.h"

namespace intaglio::sort {
namespace {

constexpr std::size_t kLeafSize = 8;

/// Whether an offset (dx, dy across, dz up, from the apex) is inside the cone.
bool Inside(double dx, double dy, double dz, const BeamCone& cone) {
  return cone.Shades(std::sqrt(dx * dx + dy * dy), dz);
}

/// How wide a box is across, seen from the leaning axis.
struct Across {
  double near_mm, far_mm;
};

Across AcrossOf(double low_mm, double high_mm, double lean_ratio, double low_up_mm,
                double high_up_mm) {
  if (lean_ratio != 0) {
    constexpr double kHairMm = 1e-9;
    const double a = lean_ratio * low_up_mm, b = lean_ratio * high_up_mm;
    low_mm -= std::max(a, b) + kHairMm;
    high_mm -= std::min(a, b) - kHairMm;
  }
  return {std::max({low_mm, -high_mm, 0.0}), std::max(high_mm, -low_mm)};
}

/// Points in the order in which they were made.
struct MadePoints {
  const PointList& points_mm;
  std::span<const std::uint32_t> order;  ///< places in points_mm
  bool all_in_order;                     ///< `order` is not needed: it is 0, 1, 2 ...

  std::size_t size() const { return all_in_order ? points_mm.size() : order.size(); }
  const Vec3& operator[](std::size_t rank) const {
    return points_mm[all_in_order ? rank : order[rank]];
  }
};

/// Inside the cone of the point made `rank`-th, is there a crack made before it?
class CrackTree {
 public:
  CrackTree(const MadePoints& made_mm, const BeamCone& cone)
      : made_mm_(made_mm), cone_(cone), ranks_(made_mm.size()) {
    std::iota(ranks_.begin(), ranks_.end(), 0U);
    nodes_.reserve(made_mm.size() / 2 + 1);
    if (!ranks_.empty()) Build(0, ranks_.size());
  }

  bool IsViolated(std::uint32_t rank) const {
    return !nodes_.empty() && HasEarlierCrack(0, rank, cone_.LeanAt(made_mm_[rank]));
  }

 private:
  struct Node {
    Box3 box;
    std::uint32_t first_rank = 0;
    std::uint32_t begin = 0;  ///< of its points in ranks_
    std::uint32_t end = 0;
    std::uint32_t right = 0;  ///< second child, 0 in a leaf; the first follows its parent
  };

  std::uint32_t Build(std::size_t begin, std::size_t end) {
    const auto self = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    Node node;
    node.begin = static_cast<std::uint32_t>(begin);
    node.end = static_cast<std::uint32_t>(end);
    node.first_rank =
        *std::min_element(ranks_.begin() + static_cast<std::ptrdiff_t>(begin),
                          ranks_.begin() + static_cast<std::ptrdiff_t>(end));
    for (std::size_t i = begin; i < end; ++i) node.box.Extend(made_mm_[ranks_[i]]);
    if (end - begin > kLeafSize) {
      int axis = 0;
      node.box.size_mm().maxCoeff(&axis);
      const std::size_t middle = begin + (end - begin) / 2;
      const auto at = [this](std::size_t i) {
        return ranks_.begin() + static_cast<std::ptrdiff_t>(i);
      };
      std::nth_element(at(begin), at(middle), at(end),
                       [this, axis](std::uint32_t a, std::uint32_t b) {
                         return made_mm_[a][axis] < made_mm_[b][axis];
                       });
      Build(begin, middle);
      node.right = Build(middle, end);
    }
    nodes_[self] = node;
    return self;
  }

  bool HasEarlierCrack(std::uint32_t index, std::uint32_t rank, const Vec2& lean) const {
    const Node& node = nodes_[index];
    if (node.first_rank >= rank) return false;
    const Vec3& p = made_mm_[rank];
    const Vec3 low = node.box.min_mm - p;
    const Vec3 high = node.box.max_mm - p;
    if (high.z() <= 0) return false;
    const double low_up_mm = std::max(low.z(), 0.0);
    const Across x = AcrossOf(low.x(), high.x(), lean.x(), low_up_mm, high.z());
    const Across y = AcrossOf(low.y(), high.y(), lean.y(), low_up_mm, high.z());
    if (!Inside(x.near_mm, y.near_mm, high.z(), cone_)) return false;
    if (Inside(x.far_mm, y.far_mm, low.z(), cone_)) return true;
    if (node.right != 0) {
      return HasEarlierCrack(index + 1, rank, lean) ||
             HasEarlierCrack(node.right, rank, lean);
    }
    return std::any_of(ranks_.begin() + node.begin, ranks_.begin() + node.end,
                       [&](std::uint32_t other) {
                         return other < rank && cone_.Shades(made_mm_[other] - p, lean);
                       });
  }

  MadePoints made_mm_;
  BeamCone cone_;
  std::vector<std::uint32_t> ranks_;
  std::vector<Node> nodes_;
};

/// Calls take(rank) for each violated point.
template <typename Take>
void ForEachViolated(const MadePoints& made_mm, const BeamCone& cone, Take&& take) {
  RequireUsable(cone);
  Require(made_mm.size() <= std::numeric_limits<std::uint32_t>::max(),
          "{} points are too many to check", made_mm.size());
  const CrackTree tree(made_mm, cone);
  for (std::uint32_t rank = 0; rank < made_mm.size(); ++rank) {
    if (tree.IsViolated(rank)) take(rank);
  }
}

std::uint64_t CountViolated(const MadePoints& made_mm, const BeamCone& cone) {
  std::uint64_t violations = 0;
  ForEachViolated(made_mm, cone, [&](std::uint32_t) { ++violations; });
  return violations;
}

bool IsEachInTurn(std::span<const std::uint32_t> order) {
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    if (order[rank] != rank) return false;
  }
  return true;
}

/// Of points in several channels, by each channel that decides.
std::uint64_t CountByChannel(const MadePoints& made_mm,
                             std::span<const ChannelMask> masks, const BeamCone& cone) {
  const auto place_at = [&](std::uint32_t rank) {
    return made_mm.all_in_order ? rank : made_mm.order[rank];
  };
  std::vector<bool> violated(made_mm.points_mm.size(), false);
  for (const ChannelMask channel : DistinctChannels(masks)) {
    std::vector<std::uint32_t> in_channel;
    for (std::uint32_t rank = 0; rank < made_mm.size(); ++rank) {
      if (ShareChannel(masks[place_at(rank)], channel))
        in_channel.push_back(place_at(rank));
    }
    ForEachViolated({made_mm.points_mm, in_channel, false}, cone,
                    [&](std::uint32_t rank) { violated[in_channel[rank]] = true; });
  }
  return static_cast<std::uint64_t>(std::count(violated.begin(), violated.end(), true));
}

std::uint64_t CountWithMasks(const MadePoints& made_mm,
                             std::span<const ChannelMask> masks, const BeamCone& cone) {
  Require(masks.size() == made_mm.points_mm.size(), "{} points have {} masks",
          made_mm.points_mm.size(), masks.size());
  return HaveOneMask(masks) ? CountViolated(made_mm, cone)
                            : CountByChannel(made_mm, masks, cone);
}

}  // namespace

std::uint64_t CountShadowViolations(const PointList& made_mm, const BeamCone& cone) {
  return CountViolated({made_mm, {}, true}, cone);
}

std::uint64_t CountShadowViolations(const PointList& made_mm,
                                    std::span<const ChannelMask> masks,
                                    const BeamCone& cone) {
  return CountWithMasks({made_mm, {}, true}, masks, cone);
}

std::uint64_t CountShadowViolations(const PointList& points_mm,
                                    std::span<const ChannelMask> masks,
                                    std::span<const std::uint32_t> made_order,
                                    const BeamCone& cone) {
  const bool all_in_order =
      made_order.size() == points_mm.size() && IsEachInTurn(made_order);
  return CountWithMasks({points_mm, made_order, all_in_order}, masks, cone);
}

}  // namespace intaglio::sort
