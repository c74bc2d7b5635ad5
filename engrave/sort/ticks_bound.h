#pragma once

// A lower bound of the ticks that any order of a cloud takes, proved: no order, no start
// and no motion within the limits takes fewer, so the distance of an order from it is the
// most that can still be gained.
//
// Let a motion pass the points in some order, step i from one point to the next in n_i
// ticks of T, a whole number, 1 or more. Of each axis by itself, |v| <= V and |a| <= A:
//   (1) |d_i| <= V n_i T.
//   (2) The mean velocity of a step differs from the velocity at its end by A n T / 2 at
//       most, because |mean - v(end)| = |integral of a(s) s / (n T)| over the step, and
//       so does that of the next step from the velocity at its start. At the point
//       between two steps both velocities are one:
//         |d2 / (n2 T) - d1 / (n1 T)| <= A T (n1 + n2) / 2.
// Let c(p) be the smallest n1 + n2 with which p can be passed at all, from any other
// point q to any third one r, by (1) and (2). Every point but the first and the last is
// between two steps, and every step is beside two points:
//   2 sum n_i = sum over the points between of (n_before + n_after) + n_first + n_last
//            >= sum of c(p) over all points - the two largest c(p) + 2.
// What the planner has to keep besides (rests, jerk, lengths of vectors, the beam's
// shadow, the order of channels, more than two steps at once) only adds ticks. Points
// that may be moved by up to the tolerance e are shifted by no more than 2 e in d, which
// is added in (1) and (2).

#include <cstdint>

#include "engrave/core/executor.h"
#include "engrave/core/geometry.h"
#include "engrave/motion/axis/limits.h"

namespace intaglio::sort {

struct TicksBoundOptions {
  /// In the frame of the points. Limits of lengths count as limits of each axis; jerk and
  /// travel are not regarded.
  motion::Limits limits;
  double rate_hz = 100;  ///< lamp sync, 1..50000
  /// How far the planner may move a point, >= 0.
  double tolerance_mm = 0;
  Executor executor;  ///< The bound does not depend on it.
};

/// In ticks from the first point to the last; 0 for fewer than two points. Some
/// microseconds a point where a step takes one tick, at the most 50; where c(p) would
/// take longer, it is what was proved so far.
std::uint64_t TicksBound(PointList points_mm, const TicksBoundOptions& options);

}  // namespace intaglio::sort
