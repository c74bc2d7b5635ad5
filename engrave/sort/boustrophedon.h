#pragma once

// Boustrophedon sort: slabs of equal thickness from the lowest up, in each of them rows
// of one direction one beside the other, every other row and every other slab backwards.
// The method of many engraving programs; good for solid fills on a grid with rows along
// those of the grid, for comparison elsewhere.

#include "engrave/sort/order.h"

namespace intaglio::sort {

Status CheckBoustrophedonOptions(const OrderOptions& options);

/// Where a slab holds points above one another, they are made from below (cone_order.h).
/// Options and points must have been checked by MakeOrder.
Result<Order> OrderByBoustrophedon(const PointList& points_mm,
                                   const OrderOptions& options,
                                   const ProgressSink& progress);

}  // namespace intaglio::sort
