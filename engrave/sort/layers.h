#pragma once

// Sort by layers (Trochimczuk 2008 ch. 6.7 and annex E): slabs of equal thickness from
// the lowest up; within a slab always to the nearest remaining point in the XY plane, by
// max(|dx|, |dy|), starting from where the slab below ended.
//
// Inside a slab heights count only where points lie above one another in the beam
// (cone_order.h), so a slab should hold no more than one layer of a layered cloud.

#include "engrave/sort/order.h"

namespace intaglio::sort {

Status CheckLayersOptions(const OrderOptions& options);

/// Starts at the lowest point. Equal distances: the smallest z, then y, then x, then
/// index. Options and points must have been checked by MakeOrder.
Result<Order> OrderByLayers(const PointList& points_mm, const OrderOptions& options,
                            const ProgressSink& progress);

}  // namespace intaglio::sort
