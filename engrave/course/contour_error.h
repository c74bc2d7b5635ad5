#pragma once

// How far a course that was really driven is from its path, both ways (Hausdorff):
//  - one-sided: from each actual point to the nearest place of the path;
//  - node miss: from each node of the path to the nearest place of the course. One-sided
//    alone lets sharp tips be cut off.
// The nearest place is searched only in a window of arc length around where the point was
// commanded, so that a course cannot be excused by another leg that happens to pass.

#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/course/path.h"

namespace intaglio::course {

struct SearchWindow {
  double back_mm = 0;   ///< how far behind the commanded place the axes may be
  double ahead_mm = 0;  ///< how far before it
};

/// The place of the path that is nearest to an actual point. Of a point before which a
/// greater error lies, between it and the one before, the distance is that error.
struct NearestPlace {
  double distance_mm = 0;
  double s_mm = 0;
};

struct ContourError {
  /// For each node: greatest error of the actual points whose nearest place is nearest to
  /// this node, and of those on the segment behind it.
  std::vector<double> one_sided_mm;
  std::vector<double> node_miss_mm;  ///< for each node
  double worst_one_sided_mm = 0, worst_node_miss_mm = 0;

  double worst_mm() const {
    return worst_one_sided_mm > worst_node_miss_mm ? worst_one_sided_mm
                                                   : worst_node_miss_mm;
  }
};

/// The same for a part of a course: of the nodes that it may be near to. Of a node beside
/// its ends the greatest one-sided error, or the least miss, of all parts counts; parts
/// that share one instant miss nothing.
struct PartError {
  std::size_t first_node = 0;
  std::vector<double> one_sided_mm, node_miss_mm;
};

/// `actual_mm` and `commanded_s_mm` (ascending, from below 0 to beyond the path's length)
/// have the same size, two or more. Where the nearest place changes its segment between
/// two samples the course between them is examined too. `places` (may be empty) gets
/// the place of each sample.
ContourError MeasureContour(const Path& path, std::span<const Vec2> actual_mm,
                            std::span<const double> commanded_s_mm,
                            const SearchWindow& window,
                            std::span<NearestPlace> places = {});
PartError MeasurePart(const Path& path, std::span<const Vec2> actual_mm,
                      std::span<const double> commanded_s_mm, const SearchWindow& window);

/// A course that was measured whole, beside which others run a little off: their greatest
/// error without measuring each of their places, of which most are too near to count.
class NeighbourError {
 public:
  /// The spans have to outlive it.
  NeighbourError(const Path& path, std::span<const Vec2> actual_mm,
                 std::span<const double> commanded_s_mm, const SearchWindow& window);
  /// The greater of both errors of a course with the same commands; of nodes, those whose
  /// nearest place of the measured course is one of first .. last - 1.
  double WorstOf(std::span<const Vec2> other_mm, std::size_t first,
                 std::size_t last) const;

 private:
  struct NodePlace {
    std::size_t node = 0, instant = 0;
    double distance_mm = 0;
  };

  const Path& path_;
  std::span<const Vec2> actual_mm_;
  std::span<const double> commanded_s_mm_;
  SearchWindow window_;
  std::vector<double> distance_mm_;  ///< of each instant
  std::vector<NodePlace> nodes_;
};

}  // namespace intaglio::course
