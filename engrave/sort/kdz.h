#pragma once

// Sort Kdz: the next point is the remaining one of minimum
//   max(|dx|, |dy|) + K (z_next - z_now),
// Trochimczuk 2008 ch. 6.7 and annex E, corrected: the source weighs |dz|, which prefers
// a near point above to a farther one below and so fires through earlier cracks. With the
// sign kept, and K not less than the tangent of the beam's cone, it never does (proof in
// the .cc). Exact: no approximation in the search.

#include "engrave/sort/order.h"

namespace intaglio::sort {

/// The minimum K that never fires through an earlier crack, but not below 0.6; above that
/// larger values do not shorten the moves.
double DefaultUpRatio(const BeamCone& cone);

Status CheckKdzOptions(const OrderOptions& options);

/// Starts at the lowest point (of equal z the smallest y, then x). Equal costs: the
/// smallest z, then y, then x, then index. Options and points must have been checked by
/// MakeOrder.
Result<Order> OrderByKdz(const PointList& points_mm, const OrderOptions& options,
                         const ProgressSink& progress);

}  // namespace intaglio::sort
