#pragma once

// Sort for the stage: the next point is the one that can be reached in the fewest ticks
// with the least change of velocity, of the points that are near by the cost of sort Kdz
// (kdz.h). It follows a contour to its end in its direction, where the nearest point
// would often be a step aside.
//
// Never through an earlier crack: a point that would shade one that is left waits. There
// is always one that does not wait: the first choice of sort Kdz never does, whatever was
// taken before (proof in kdz.cc).

#include "engrave/sort/order.h"

namespace intaglio::sort {

Status CheckSmoothOptions(const OrderOptions& options);

/// Starts at the lowest point (lowest_point.h). Tries several weights of distance, height
/// and bends, unless the first leaves nothing to gain, and returns the order that the
/// motion planner makes in the fewest ticks. options.executor may try them at the same
/// time. Memory: 80 bytes a point for each of them. Points and options must have been
/// checked by MakeOrder.
Result<Order> OrderSmoothly(const PointList& points_mm, const OrderOptions& options,
                            const ProgressSink& progress);

}  // namespace intaglio::sort
