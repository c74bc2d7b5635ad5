#pragma once

// The points that are still to be made, searchable for the one of minimum
//   max(|x - x_now|, |y - y_now|) + z_weight * z.
// The greedy sorters take their points out of it one by one.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/sort/beam/beam_cone.h"

namespace intaglio::sort {

class RemainingPoints {
 public:
  /// members: indices into points_mm. z_weight >= 0. Less than 64 bytes a member;
  /// points_mm is not kept.
  RemainingPoints(const PointList& points_mm, std::span<const std::uint32_t> members,
                  double z_weight);

  std::size_t size() const { return size_; }

  /// A point taken: its place along with its index, because the place is in the cache
  /// here, but not in the cloud.
  struct Taken {
    std::uint32_t index;
    double x_mm;
    double y_mm;
  };

  /// Takes out the point of minimum cost as seen from (x, y). Equal costs: the order of
  /// lowest_point.h. There must be a point left.
  Taken TakeNearest(double x_mm, double y_mm);

  /// A point found and not yet taken; stale once any point was taken.
  struct Candidate {
    Vec3 position_mm;
    double cost;  ///< less z_weight times the z one comes from
    std::uint32_t index;
    std::uint32_t leaf;
    std::uint32_t slot;
  };

  /// Replaces `found` by the `count` points of minimum cost as seen from (x, y), or by
  /// all that are left, the cheapest first; equal costs in the order of lowest_point.h.
  void FindNearest(double x_mm, double y_mm, std::size_t count,
                   std::vector<Candidate>& found) const;

  void Take(const Candidate& candidate);
  /// `index` is of a point that is left.
  void Take(std::uint32_t index);
  bool IsLeft(std::uint32_t index) const;

  /// One of the points left that `point_mm`, made now, would shade. z_weight > 0.
  std::optional<std::uint32_t> FindShaded(const Vec3& point_mm,
                                          const BeamCone& cone) const;
  bool Shades(const Vec3& point_mm, const BeamCone& cone) const {
    return FindShaded(point_mm, cone).has_value();
  }

 private:
  static constexpr std::size_t kFan = 8;

  /// Up to kFan points, the taken ones of infinite lift and behind the others.
  struct alignas(64) Leaf {
    double x[kFan];
    double y[kFan];
    double lift[kFan];  ///< z_weight * z
    double z[kFan];
    std::uint32_t index[kFan];
    std::uint32_t count;
  };

  /// Bounds of kFan children, relative to origin_: structure of arrays for the vector
  /// unit, in floats to fit the cache. Rounded: see slack_.
  struct alignas(32) Node {
    float min_x[kFan];
    float max_x[kFan];
    float min_y[kFan];
    float max_y[kFan];
    float min_lift[kFan];
  };

  struct Bounds {
    float min_x, max_x, min_y, max_y, min_lift;
    bool operator==(const Bounds&) const = default;
  };

  /// The position of a search, and the cost above which a subtree is not searched.
  struct Search {
    double x, y;
    float rel_x, rel_y;
    float slack;
    float limit;  ///< no child whose bound is above can hold a better point
  };
  struct SearchForOne;
  struct SearchForSome;

  void FillLeaves(const PointList& points_mm, std::span<const std::uint32_t> along_curve,
                  double z_weight);
  void BuildLevels();
  Bounds BoundsOfLeaf(const Leaf& leaf) const;
  static Bounds BoundsOfNode(const Node& node);
  static void SetChild(Node& node, std::size_t child, const Bounds& bounds);
  static Bounds ChildOf(const Node& node, std::size_t child);
  static void BoundChildren(const Node& node, const Search& search, float (&bound)[kFan]);
  Search StartAt(double x_mm, double y_mm) const;
  void Scan(std::size_t leaf, SearchForOne& search) const;
  void Scan(std::size_t leaf, SearchForSome& search) const;
  template <typename AnySearch>
  void VisitChildren(std::size_t level, std::size_t node, std::size_t skipped,
                     AnySearch& search) const;
  template <typename AnySearch>
  void VisitAll(AnySearch& search) const;
  std::optional<std::uint32_t> ShadedIn(std::size_t level, std::size_t node,
                                        const Vec3& point_mm, const BeamCone& cone) const;
  std::size_t SlotOf(std::uint32_t index) const;
  void Remove(std::size_t leaf, std::size_t slot);

  std::vector<Leaf> leaves_;
  std::vector<std::uint32_t> leaf_of_;  ///< of each point of the cloud
  /// levels_[0] has the leaves as children, the last level is one node.
  std::vector<std::vector<Node>> levels_;
  double z_weight_ = 0;
  double origin_x_ = 0;
  double origin_y_ = 0;
  double origin_lift_ = 0;
  double half_width_ = 0;  ///< largest |x - origin| or |y - origin|
  double half_lift_ = 0;
  std::size_t size_ = 0;
  std::size_t last_leaf_ = 0;
};

}  // namespace intaglio::sort
