#pragma once

// Orders that a sweep begins with, and the heights of its slow axis along them.
//
// Slabs: points of equal height within a thickness, deepest slab first, in each the
// nearest point next. The points of a slab may change places as they like, so contours
// are followed well.
//
// Rounds: the mirrors go round the field on a closed curve while the axis rises steadily,
// a pitch a round. At each place of the curve the axis passes a pitch between two visits,
// so the points of a round lie half of the pitch above or below it at most: with the same
// tolerance a round is twice as thick as a slab whose order does not know heights, and
// among more points the way from one to the next is shorter.

#include <cstddef>
#include <vector>

#include "engrave/core/progress.h"
#include "engrave/sort/order.h"

namespace intaglio::sort {

struct SweptOrder {
  Order order;
  /// The ends of the pieces of the order within which points may change places.
  std::vector<std::size_t> ends;
  /// Of each place the height of the axis, never falling; empty: the points of a piece
  /// may change places whatever their heights.
  std::vector<double> axis_mm = {};
};

/// `lifted_mm`: the points with their heights, mm, as the axis counts them; one at least.
/// Slabs are `slab_mm` thick.
SweptOrder BeginInSlabs(const PointList& lifted_mm, double slab_mm);

/// `pitch_mm` > 0: how far the axis rises in a round.
SweptOrder BeginInRounds(const PointList& lifted_mm, double pitch_mm);

}  // namespace intaglio::sort
