// A k-d tree over the points that are left; each node has the box around them. The
// minimum cost possible in a box bounds the search from below.

#include "engrave/sort/published_kdz.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "engrave/sort/beam/lowest_point.h"

namespace intaglio::sort {
namespace {

constexpr double kMaxRatio = 100;
constexpr std::size_t kBucketSize = 8;
constexpr std::size_t kPublishedReportPoints = 1 << 12;

double Outside(double low, double high, double at) {
  return std::max({low - at, at - high, 0.0});
}

class PointTree {
 public:
  PointTree(const PointList& points_mm, const PublishedKdzOptions& options)
      : points_mm_(points_mm),
        options_(options),
        sorted_(points_mm.size()),
        leaf_of_(points_mm.size()) {
    std::iota(sorted_.begin(), sorted_.end(), 0U);
    Build(0, sorted_.size(), kNone);
  }

  std::uint32_t TakeNearest(const Vec3& from_mm) {
    best_ = std::numeric_limits<double>::infinity();
    Search(0, from_mm);
    Remove(nearest_);
    return nearest_;
  }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  struct Node {
    Box3 box;
    std::uint32_t begin = 0, end = 0;  ///< of its points in sorted_
    std::uint32_t right = kNone;       ///< the left child follows its parent
    std::uint32_t parent = kNone;
  };

  std::uint32_t Build(std::size_t begin, std::size_t end, std::uint32_t parent) {
    const auto self = static_cast<std::uint32_t>(nodes_.size());
    nodes_.push_back({{},
                      static_cast<std::uint32_t>(begin),
                      static_cast<std::uint32_t>(end),
                      kNone,
                      parent});
    for (std::size_t i = begin; i < end; ++i) {
      nodes_[self].box.Extend(points_mm_[sorted_[i]]);
    }
    if (end - begin <= kBucketSize) {
      for (std::size_t i = begin; i < end; ++i) leaf_of_[sorted_[i]] = self;
      return self;
    }
    int axis = 0;
    nodes_[self].box.size_mm().maxCoeff(&axis);
    const std::size_t middle = begin + (end - begin) / 2;
    const auto at = [this](std::size_t i) {
      return sorted_.begin() + static_cast<std::ptrdiff_t>(i);
    };
    std::nth_element(at(begin), at(middle), at(end), [&](auto a, auto b) {
      return points_mm_[a][axis] < points_mm_[b][axis];
    });
    Build(begin, middle, self);
    const std::uint32_t right = Build(middle, end, self);
    nodes_[self].right = right;
    return self;
  }

  double CostOf(double across_mm, double up_mm) const {
    return across_mm +
           (up_mm > 0 ? options_.up_ratio * up_mm : -options_.down_ratio * up_mm);
  }

  double Bound(std::uint32_t index, const Vec3& from_mm) const {
    const Box3& box = nodes_[index].box;
    if (box.empty()) return std::numeric_limits<double>::infinity();
    const double x = Outside(box.min_mm.x(), box.max_mm.x(), from_mm.x());
    const double y = Outside(box.min_mm.y(), box.max_mm.y(), from_mm.y());
    const double up =
        std::clamp(from_mm.z(), box.min_mm.z(), box.max_mm.z()) - from_mm.z();
    return CostOf(std::max(x, y), up);
  }

  void Search(std::uint32_t index, const Vec3& from_mm) {
    const Node& node = nodes_[index];
    if (node.right != kNone) {
      std::pair near(Bound(index + 1, from_mm), index + 1);
      std::pair far(Bound(node.right, from_mm), node.right);
      if (far.first < near.first) std::swap(near, far);
      if (near.first <= best_ && near.first < kInfinity) Search(near.second, from_mm);
      if (far.first <= best_ && far.first < kInfinity) Search(far.second, from_mm);
      return;
    }
    for (std::uint32_t i = node.begin; i < node.end; ++i) {
      const std::uint32_t point = sorted_[i];
      const Vec3 d = points_mm_[point] - from_mm;
      const double cost = CostOf(std::max(std::abs(d.x()), std::abs(d.y())), d.z());
      if (cost > best_) continue;
      if (cost == best_ &&
          !ComesFirst(points_mm_[point], point, points_mm_[nearest_], nearest_)) {
        continue;
      }
      best_ = cost;
      nearest_ = point;
    }
  }

  void Remove(std::uint32_t point) {
    std::uint32_t index = leaf_of_[point];
    Node& leaf = nodes_[index];
    const auto begin = sorted_.begin() + leaf.begin;
    const auto last = sorted_.begin() + leaf.end - 1;
    std::iter_swap(std::find(begin, last, point), last);
    --leaf.end;
    leaf.box = {};
    for (std::uint32_t i = leaf.begin; i < leaf.end; ++i) {
      leaf.box.Extend(points_mm_[sorted_[i]]);
    }
    while ((index = nodes_[index].parent) != kNone) {
      Node& node = nodes_[index];
      node.box = {};
      for (const std::uint32_t child : {index + 1, node.right}) {
        if (nodes_[child].box.empty()) continue;
        node.box.Extend(nodes_[child].box.min_mm);
        node.box.Extend(nodes_[child].box.max_mm);
      }
    }
  }

  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const PointList& points_mm_;
  PublishedKdzOptions options_;
  std::vector<std::uint32_t> sorted_;
  std::vector<std::uint32_t> leaf_of_;
  std::vector<Node> nodes_;
  double best_ = kInfinity;
  std::uint32_t nearest_ = 0;
};

}  // namespace

Status CheckPublishedKdzOptions(const OrderOptions& options) {
  const std::pair<const char*, double> ratios[] = {
      {"up_ratio", options.published_kdz.up_ratio},
      {"down_ratio", options.published_kdz.down_ratio}};
  for (const auto& [name, ratio] : ratios) {
    if (ratio >= 0 && ratio <= kMaxRatio) continue;
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("published_kdz.{}: {} is outside 0..{}", name, ratio, kMaxRatio),
        fmt::format("{}", ratio));
  }
  return {};
}

Result<Order> OrderByPublishedKdz(const PointList& points_mm, const OrderOptions& options,
                                  const ProgressSink& progress) {
  Order order(points_mm.size());
  if (points_mm.empty()) return order;
  PointTree tree(points_mm, options.published_kdz);
  Vec3 now_mm = points_mm[LowestPoint(points_mm)];
  for (std::size_t made = 0; made < order.size(); ++made) {
    if (progress && made % kPublishedReportPoints == 0 && !progress(made, order.size())) {
      return Fail(ErrorCode::kCancelled, "the sort was cancelled");
    }
    order[made] = tree.TakeNearest(now_mm);
    now_mm = points_mm[order[made]];
  }
  return order;
}

}  // namespace intaglio::sort
