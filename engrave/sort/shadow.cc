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

/// Inside the cone of the point made `rank`-th, is there a crack made before it?
class CrackTree {
 public:
  CrackTree(const PointList& made_mm, const BeamCone& cone)
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

  const PointList& made_mm_;
  BeamCone cone_;
  std::vector<std::uint32_t> ranks_;
  std::vector<Node> nodes_;
};

void RequireRanges(const PointList& made_mm, const BeamCone& cone) {
  RequireUsable(cone);
  Require(made_mm.size() <= std::numeric_limits<std::uint32_t>::max(),
          "{} points are too many to check", made_mm.size());
}

}  // namespace

std::uint64_t CountShadowViolations(const PointList& made_mm, const BeamCone& cone) {
  RequireRanges(made_mm, cone);
  const CrackTree tree(made_mm, cone);
  std::uint64_t violations = 0;
  for (std::uint32_t rank = 0; rank < made_mm.size(); ++rank) {
    if (tree.IsViolated(rank)) ++violations;
  }
  return violations;
}

std::uint64_t CountShadowViolations(const PointList& made_mm,
                                    std::span<const ChannelMask> masks,
                                    const BeamCone& cone) {
  Require(masks.size() == made_mm.size(), "{} points have {} masks", made_mm.size(),
          masks.size());
  // No copy by channel is needed.
  if (HaveOneMask(masks)) return CountShadowViolations(made_mm, cone);
  std::vector<bool> violated(made_mm.size(), false);
  for (const ChannelMask channel : DistinctChannels(masks)) {
    PointList in_channel_mm;
    std::vector<std::uint32_t> index_of;
    for (std::uint32_t at = 0; at < made_mm.size(); ++at) {
      if (!ShareChannel(masks[at], channel)) continue;
      in_channel_mm.push_back(made_mm[at]);
      index_of.push_back(at);
    }
    RequireRanges(in_channel_mm, cone);
    const CrackTree tree(in_channel_mm, cone);
    for (std::uint32_t rank = 0; rank < in_channel_mm.size(); ++rank) {
      if (tree.IsViolated(rank)) violated[index_of[rank]] = true;
    }
  }
  return static_cast<std::uint64_t>(std::count(violated.begin(), violated.end(), true));
}

}  // namespace intaglio::sort
