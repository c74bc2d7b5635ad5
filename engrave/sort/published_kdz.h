#pragma once

// Sort Kdz as published (Trochimczuk 2008 ch. 6.7 and annex E): the next point is the
// remaining one of minimum
//   max(|dx|, |dy|) + K(dz) |dz|,
// with one K for steps up and another for steps down. For comparison only: a near point
// above is preferred to a farther one below, so points are fired through earlier cracks,
// a fifth to two thirds of them (shadow.h counts).

#include "engrave/sort/order.h"

namespace intaglio::sort {

Status CheckPublishedKdzOptions(const OrderOptions& options);

/// Starts at the lowest point. Equal costs: the order of lowest_point.h. Options and
/// points must have been checked by MakeOrder.
Result<Order> OrderByPublishedKdz(const PointList& points_mm, const OrderOptions& options,
                                  const ProgressSink& progress);

}  // namespace intaglio::sort
