#pragma once

// Sort Kdz as published (Trochimczuk 2008 ch. 6.7 and annex E): the next point is the
// remaining one of least
//   max(|dx|, |dy|) + K(dz) |dz|,
// with one K for steps up and another for steps down. For comparison with what it is
// measured against: a near point above is preferred to a farther one below, so points are
// fired through earlier cracks, a fifth to two thirds of them (shadow.h counts).

#include "engrave/sort/order.h"

namespace intaglio::sort {

Status CheckPublishedKdzOptions(const OrderOptions& options);

/// Starts at the lowest point. Equal costs: as lowest_point.h has it. Options and points
/// as MakeOrder has checked them.
Result<Order> OrderByPublishedKdz(const PointList& points_mm, const OrderOptions& options,
                                  const ProgressSink& progress);

}  // namespace intaglio::sort
