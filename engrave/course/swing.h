#pragma once

// The swing at a corner: the reference leaves the path for a while before and behind the
// corner, so that what the kernel makes of it uses the tolerance on both sides of both
// legs and is the fastest that motors and tolerance allow. A swing is an offset in time,
// mm, for one speed at the corner; at another speed it is as many times larger, and so
// are errors and accelerations of the corner.

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::course {

struct SpeedLaw;
class Path;

/// Straight between its knots, zero half_s() before and behind the corner.
struct SwingShape {
  double speed_mm_s = 0;  ///< at the corner, for which it is made
  double knot_s = 0;      ///< between its knots
  std::vector<Vec2> knots_mm;

  double half_s() const { return knot_s * static_cast<double>(knots_mm.size() + 1) / 2; }
  /// `t_s` behind the corner.
  Vec2 At(double t_s) const;
};

/// A node's swing: a shape, turned or mirrored.
struct NodeSwing {
  int shape = -1;  ///< -1: none
  Eigen::Matrix2d path_from_shape = Eigen::Matrix2d::Identity();
};

struct Swings {
  std::vector<SwingShape> shapes;
  std::vector<NodeSwing> of_node;  ///< for each node
  double longest_half_s = 0;
};

/// Adds the swings of a law to the points of its reference at the times first_s + i
/// period_s.
void AddSwings(const Path& path, const SpeedLaw& law, double first_s, double period_s,
               std::span<Vec2> points_mm);

}  // namespace intaglio::course
