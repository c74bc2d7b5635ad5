// A packed tree: the points along a Hilbert curve, eight to a leaf, eight leaves to a
// node and so on, bottom up. The tree keeps its shape; bounds shrink as points are taken.
// A search starts at the leaf of the last point taken, where the next one mostly is, and
// climbs to the root, searching only those subtrees whose bound
//   max(distance of the box in x, in y) + least lift in it
// is not above the best cost so far. On the way down the cheapest child comes first.
//
// The metric has no lower bound in z, which is why a node keeps the minimum lift of its
// remaining points, and not a box in z.
//
// Points are compared in double, so the result is exact. Bounds are floats relative to
// the middle of the cloud. With M the largest of the coordinates so taken and L of the
// lifts, and e = 2^-24: the two conversions, the difference, the lift's conversion, the
// sum, and the best cost's conversion together err by less than e (1 + 1 + 2 + 2) M + e
// (1 + 1) L + e (2 M + L), below 6e-7 (M + L). A slack of 1e-6 (M + L) on the limit makes
// up for it.

#include "engrave/sort/beam/remaining_points.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "engrave/core/check.h"
#include "engrave/sort/beam/hilbert.h"
#include "engrave/sort/beam/lowest_point.h"

namespace intaglio::sort {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr float kInfinityF = std::numeric_limits<float>::infinity();
constexpr double kSlackShare = 1e-6;

}  // namespace

/// The cheapest point so far.
struct RemainingPoints::SearchForOne : Search {
  double best = kInfinity;
  std::size_t leaf = 0;
  std::size_t slot = 0;
};

/// The cheapest `count` points so far, a heap with the dearest in front.
struct RemainingPoints::SearchForSome : Search {
  std::size_t count;
  std::vector<Candidate>& found;

  static bool Cheaper(const Candidate& a, const Candidate& b) {
    if (a.cost != b.cost) return a.cost < b.cost;
    return ComesFirst(a.position_mm, a.index, b.position_mm, b.index);
  }
};

RemainingPoints::RemainingPoints(const PointList& points_mm,
                                 std::span<const std::uint32_t> members, double z_weight)
    : z_weight_(z_weight), size_(members.size()) {
  Require(z_weight >= 0 && std::isfinite(z_weight),
          "z_weight must not be negative, is {}", z_weight);
  Box3 box;
  for (const std::uint32_t i : members) box.Extend(points_mm[i]);
  if (!members.empty()) {
    const Vec3 center_mm = box.center_mm();
    const Vec3 half_mm = 0.5 * box.size_mm();
    origin_x_ = center_mm.x();
    origin_y_ = center_mm.y();
    origin_lift_ = z_weight * center_mm.z();
    half_width_ = std::max(half_mm.x(), half_mm.y());
    half_lift_ = z_weight * half_mm.z();
  }
  FillLeaves(points_mm, AlongHilbertCurve(points_mm, members, z_weight == 0), z_weight);
  BuildLevels();
}

void RemainingPoints::FillLeaves(const PointList& points_mm,
                                 std::span<const std::uint32_t> along_curve,
                                 double z_weight) {
  leaf_of_.resize(points_mm.size());
  leaves_.resize((along_curve.size() + kFan - 1) / kFan);
  for (std::size_t i = 0; i < leaves_.size() * kFan; ++i) {
    Leaf& leaf = leaves_[i / kFan];
    const std::size_t slot = i % kFan;
    if (i >= along_curve.size()) {
      leaf.x[slot] = leaf.y[slot] = leaf.z[slot] = 0;
      leaf.lift[slot] = kInfinity;
      continue;
    }
    const Vec3& p = points_mm[along_curve[i]];
    leaf.x[slot] = p.x();
    leaf.y[slot] = p.y();
    leaf.z[slot] = p.z();
    leaf.lift[slot] = z_weight * p.z();
    leaf.index[slot] = along_curve[i];
    leaf_of_[along_curve[i]] = static_cast<std::uint32_t>(i / kFan);
    ++leaf.count;
  }
}

void RemainingPoints::BuildLevels() {
  const Bounds none{kInfinityF, -kInfinityF, kInfinityF, -kInfinityF, kInfinityF};
  std::size_t children = leaves_.size();
  do {
    std::vector<Node> level((children + kFan - 1) / kFan);
    for (std::size_t i = 0; i < level.size() * kFan; ++i) {
      Bounds bounds = none;
      if (i < children) {
        bounds =
            levels_.empty() ? BoundsOfLeaf(leaves_[i]) : BoundsOfNode(levels_.back()[i]);
      }
      SetChild(level[i / kFan], i % kFan, bounds);
    }
    children = level.size();
    levels_.push_back(std::move(level));
  } while (children > 1);
}

RemainingPoints::Bounds RemainingPoints::BoundsOfLeaf(const Leaf& leaf) const {
  double min_x = kInfinity;
  double max_x = -kInfinity;
  double min_y = kInfinity;
  double max_y = -kInfinity;
  double min_lift = kInfinity;
  for (std::size_t i = 0; i < leaf.count; ++i) {
    min_x = std::min(min_x, leaf.x[i]);
    max_x = std::max(max_x, leaf.x[i]);
    min_y = std::min(min_y, leaf.y[i]);
    max_y = std::max(max_y, leaf.y[i]);
    min_lift = std::min(min_lift, leaf.lift[i]);
  }
  return {static_cast<float>(min_x - origin_x_), static_cast<float>(max_x - origin_x_),
          static_cast<float>(min_y - origin_y_), static_cast<float>(max_y - origin_y_),
          static_cast<float>(min_lift - origin_lift_)};
}

RemainingPoints::Bounds RemainingPoints::BoundsOfNode(const Node& node) {
  Bounds all = ChildOf(node, 0);
  for (std::size_t i = 1; i < kFan; ++i) {
    all.min_x = std::min(all.min_x, node.min_x[i]);
    all.max_x = std::max(all.max_x, node.max_x[i]);
    all.min_y = std::min(all.min_y, node.min_y[i]);
    all.max_y = std::max(all.max_y, node.max_y[i]);
    all.min_lift = std::min(all.min_lift, node.min_lift[i]);
  }
  return all;
}

void RemainingPoints::SetChild(Node& node, std::size_t child, const Bounds& bounds) {
  node.min_x[child] = bounds.min_x;
  node.max_x[child] = bounds.max_x;
  node.min_y[child] = bounds.min_y;
  node.max_y[child] = bounds.max_y;
  node.min_lift[child] = bounds.min_lift;
}

RemainingPoints::Bounds RemainingPoints::ChildOf(const Node& node, std::size_t child) {
  return {node.min_x[child], node.max_x[child], node.min_y[child], node.max_y[child],
          node.min_lift[child]};
}

void RemainingPoints::Scan(std::size_t leaf, SearchForOne& search) const {
  const Leaf& points = leaves_[leaf];
  double cost[kFan];
  for (std::size_t i = 0; i < kFan; ++i) {
    const double dx = std::abs(points.x[i] - search.x);
    const double dy = std::abs(points.y[i] - search.y);
    cost[i] = (dx > dy ? dx : dy) + points.lift[i];
  }
  for (std::size_t i = 0; i < points.count; ++i) {
    if (cost[i] > search.best) continue;
    if (cost[i] == search.best) {
      const Leaf& held = leaves_[search.leaf];
      const std::size_t s = search.slot;
      if (!ComesFirst({points.x[i], points.y[i], points.z[i]}, points.index[i],
                      {held.x[s], held.y[s], held.z[s]}, held.index[s])) {
        continue;
      }
    }
    search.best = cost[i];
    search.leaf = leaf;
    search.slot = i;
  }
  search.limit = static_cast<float>(search.best - origin_lift_) + search.slack;
}

void RemainingPoints::Scan(std::size_t leaf, SearchForSome& search) const {
  const Leaf& points = leaves_[leaf];
  for (std::size_t i = 0; i < points.count; ++i) {
    const double dx = std::abs(points.x[i] - search.x);
    const double dy = std::abs(points.y[i] - search.y);
    const Candidate candidate{{points.x[i], points.y[i], points.z[i]},
                              (dx > dy ? dx : dy) + points.lift[i],
                              points.index[i],
                              static_cast<std::uint32_t>(leaf),
                              static_cast<std::uint32_t>(i)};
    std::vector<Candidate>& found = search.found;
    if (found.size() == search.count) {
      if (!SearchForSome::Cheaper(candidate, found.front())) continue;
      std::pop_heap(found.begin(), found.end(), SearchForSome::Cheaper);
      found.pop_back();
    }
    found.push_back(candidate);
    std::push_heap(found.begin(), found.end(), SearchForSome::Cheaper);
  }
  if (search.found.size() < search.count) return;
  search.limit =
      static_cast<float>(search.found.front().cost - origin_lift_) + search.slack;
}

void RemainingPoints::BoundChildren(const Node& node, const Search& search,
                                    float (&bound)[kFan]) {
  for (std::size_t i = 0; i < kFan; ++i) {
    const float left = node.min_x[i] - search.rel_x;
    const float right = search.rel_x - node.max_x[i];
    const float front = node.min_y[i] - search.rel_y;
    const float back = search.rel_y - node.max_y[i];
    const float in_x = left > right ? left : right;
    const float in_y = front > back ? front : back;
    const float outside = in_x > in_y ? in_x : in_y;
    bound[i] = (outside > 0 ? outside : 0) + node.min_lift[i];
  }
}

template <typename AnySearch>
void RemainingPoints::VisitChildren(std::size_t level, std::size_t node,
                                    std::size_t skipped, AnySearch& search) const {
  float bound[kFan];
  BoundChildren(levels_[level][node], search, bound);
  if (skipped < kFan) bound[skipped] = kInfinityF;
  // Mostly no child has to be searched: find those that have to be before sorting.
  unsigned open = 0;
  for (std::size_t i = 0; i < kFan; ++i) {
    open |= static_cast<unsigned>(bound[i] <= search.limit) << i;
  }
  while (open != 0) {
    int next = std::countr_zero(open);
    for (unsigned rest = open & (open - 1); rest != 0; rest &= rest - 1) {
      const int i = std::countr_zero(rest);
      if (bound[i] < bound[next]) next = i;
    }
    // The limit has come down since; an empty child is below no limit but infinity.
    if (bound[next] > search.limit || bound[next] == kInfinityF) return;
    open &= ~(1U << next);
    const std::size_t child = node * kFan + static_cast<std::size_t>(next);
    if (level == 0) {
      Scan(child, search);
    } else {
      VisitChildren(level - 1, child, kFan, search);
    }
  }
}

template <typename AnySearch>
void RemainingPoints::VisitAll(AnySearch& search) const {
  Scan(last_leaf_, search);
  std::size_t child = last_leaf_;
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    VisitChildren(level, child / kFan, child % kFan, search);
    child /= kFan;
  }
}

RemainingPoints::Search RemainingPoints::StartAt(double x_mm, double y_mm) const {
  const double rel_x = x_mm - origin_x_;
  const double rel_y = y_mm - origin_y_;
  const double reach = std::max({half_width_, std::abs(rel_x), std::abs(rel_y)});
  return {x_mm,
          y_mm,
          static_cast<float>(rel_x),
          static_cast<float>(rel_y),
          static_cast<float>(kSlackShare * (reach + half_lift_)),
          kInfinityF};
}

RemainingPoints::Taken RemainingPoints::TakeNearest(double x_mm, double y_mm) {
  Require(size_ > 0, "there is no point left to take");
  SearchForOne search{StartAt(x_mm, y_mm)};
  VisitAll(search);
  const Leaf& leaf = leaves_[search.leaf];
  const Taken taken{leaf.index[search.slot], leaf.x[search.slot], leaf.y[search.slot]};
  Remove(search.leaf, search.slot);
  last_leaf_ = search.leaf;
  return taken;
}

void RemainingPoints::FindNearest(double x_mm, double y_mm, std::size_t count,
                                  std::vector<Candidate>& found) const {
  found.clear();
  if (size_ == 0 || count == 0) return;
  SearchForSome search{StartAt(x_mm, y_mm), count, found};
  VisitAll(search);
  std::sort_heap(found.begin(), found.end(), SearchForSome::Cheaper);
}

void RemainingPoints::Take(const Candidate& candidate) {
  const Leaf& leaf = leaves_[candidate.leaf];
  Require(candidate.slot < leaf.count && leaf.index[candidate.slot] == candidate.index,
          "point {} was found before another one was taken", candidate.index);
  Remove(candidate.leaf, candidate.slot);
  last_leaf_ = candidate.leaf;
}

std::size_t RemainingPoints::SlotOf(std::uint32_t index) const {
  const Leaf& leaf = leaves_[leaf_of_.at(index)];
  return static_cast<std::size_t>(std::find(leaf.index, leaf.index + leaf.count, index) -
                                  leaf.index);
}

bool RemainingPoints::IsLeft(std::uint32_t index) const {
  return size_ > 0 && SlotOf(index) < leaves_[leaf_of_.at(index)].count;
}

void RemainingPoints::Take(std::uint32_t index) {
  Require(IsLeft(index), "point {} was taken before", index);
  last_leaf_ = leaf_of_[index];
  Remove(last_leaf_, SlotOf(index));
}

std::optional<std::uint32_t> RemainingPoints::FindShaded(const Vec3& point_mm,
                                                         const BeamCone& cone) const {
  Require(z_weight_ > 0, "without a weight for z the points are not known by height");
  if (size_ == 0) return std::nullopt;
  return ShadedIn(levels_.size() - 1, 0, point_mm, cone);
}

std::optional<std::uint32_t> RemainingPoints::ShadedIn(std::size_t level,
                                                       std::size_t node,
                                                       const Vec3& point_mm,
                                                       const BeamCone& cone) const {
  const Node& bounds = levels_[level][node];
  const double slack =
      kSlackShare * (half_width_ + half_lift_ + std::abs(point_mm.x() - origin_x_) +
                     std::abs(point_mm.y() - origin_y_));
  const double x = point_mm.x() - origin_x_;
  const double y = point_mm.y() - origin_y_;
  for (std::size_t i = 0; i < kFan; ++i) {
    if (bounds.min_lift[i] == kInfinityF) continue;
    const double low_mm = (bounds.min_lift[i] - slack + origin_lift_) / z_weight_;
    const double up_mm = point_mm.z() - low_mm;
    if (up_mm <= 0) continue;
    const double near_x = std::max({bounds.min_x[i] - x, x - bounds.max_x[i], slack});
    const double near_y = std::max({bounds.min_y[i] - y, y - bounds.max_y[i], slack});
    const double reach_mm = cone.ReachMm(up_mm) + cone.SteepestLean() * up_mm;
    if (std::hypot(near_x - slack, near_y - slack) >= reach_mm) continue;
    const std::size_t child = node * kFan + i;
    if (level > 0) {
      if (const auto found = ShadedIn(level - 1, child, point_mm, cone)) return found;
      continue;
    }
    const Leaf& leaf = leaves_[child];
    for (std::size_t p = 0; p < leaf.count; ++p) {
      if (cone.Shades({leaf.x[p], leaf.y[p], leaf.z[p]}, point_mm)) return leaf.index[p];
    }
  }
  return std::nullopt;
}

void RemainingPoints::Remove(std::size_t leaf_index, std::size_t slot) {
  Leaf& leaf = leaves_[leaf_index];
  const std::size_t last = --leaf.count;
  leaf.x[slot] = leaf.x[last];
  leaf.y[slot] = leaf.y[last];
  leaf.z[slot] = leaf.z[last];
  leaf.lift[slot] = leaf.lift[last];
  leaf.index[slot] = leaf.index[last];
  leaf.lift[last] = kInfinity;
  --size_;
  Bounds bounds = BoundsOfLeaf(leaf);
  std::size_t child = leaf_index;
  for (std::vector<Node>& level : levels_) {
    Node& node = level[child / kFan];
    if (ChildOf(node, child % kFan) == bounds) return;
    SetChild(node, child % kFan, bounds);
    bounds = BoundsOfNode(node);
    child /= kFan;
  }
}

}  // namespace intaglio::sort
