#pragma once

// The k-d tree over points that the measurers of this folder search in, and what
// searches add to its own result sets. Searching is safe from several threads.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <nanoflann.hpp>

#include "engrave/core/geometry.h"

namespace intaglio::proof {

class PointTree {
 public:
  /// The points must outlive the tree.
  explicit PointTree(const PointList& points)
      : adaptor_{points},
        tree_(3, adaptor_, nanoflann::KDTreeSingleIndexAdaptorParams(16)) {}

  PointTree(const PointTree&) = delete;
  PointTree& operator=(const PointTree&) = delete;

  struct Neighbour {
    std::uint32_t index = 0;
    double square = std::numeric_limits<double>::infinity();  ///< of the distance
  };

  /// The point nearest to a place; there must be one.
  Neighbour Nearest(const Vec3& place) const {
    Neighbour found;
    tree_.knnSearch(place.data(), 1, &found.index, &found.square);
    return found;
  }

  /// The one nearest to point `index` besides itself; square infinite when it is alone.
  /// Of equal points it may be `index` itself.
  Neighbour NearestOther(std::uint32_t index) const {
    std::uint32_t indices[2];
    double squares[2];
    const Vec3& place = adaptor_.points[index];
    if (tree_.knnSearch(place.data(), 2, indices, squares) < 2) return {index};
    const int other = indices[0] == index ? 1 : 0;
    return {indices[other], squares[other]};
  }

  /// Calls take(index, square) for every point with square < radius_square, in an order
  /// that depends on the points alone, until it returns false.
  template <typename Take>
  void ForEachWithin(const Vec3& place, double radius_square, Take&& take) const {
    Within<Take> within{radius_square, take};
    tree_.findNeighbors(within, place.data(), {});
  }

 private:
  struct Adaptor {
    const PointList& points;
    std::size_t kdtree_get_point_count() const { return points.size(); }
    double kdtree_get_pt(std::size_t i, std::size_t axis) const {
      return points[i][static_cast<Eigen::Index>(axis)];
    }
    template <typename Box>
    bool kdtree_get_bbox(Box&) const {
      return false;
    }
  };
  using Tree =
      nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Adaptor>,
                                          Adaptor, 3, std::uint32_t>;

  // The interface that nanoflann requires of a result set.
  template <typename Take>
  struct Within {
    double radius_square;
    Take& take;
    bool full() const { return true; }
    double worstDist() const { return radius_square; }
    bool addPoint(double square, std::uint32_t index) {
      return square >= radius_square || take(index, square);
    }
  };

  Adaptor adaptor_;
  Tree tree_;
};

}  // namespace intaglio::proof
