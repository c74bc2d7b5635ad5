#pragma once

// The order for two fast axes above a slow one, as of a scan head over a block: z goes up
// once, in thin slabs, and may pass each point at a height of its own slab
// (motion/sweep_course.h), so inside a slab only x and y count. Below a scan head whose
// beams lean a slab is of equal heights of the lens, which reach a bent surface in the
// glass. Deepest slab first; in a slab the nearest point comes next, then pieces of the
// slab's order are changed so that the mirrors need fewer ticks without stopping
// (stretch.h).

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/sort/order.h"

namespace intaglio::sort {

Status CheckSweepOptions(const OrderOptions& options);

/// The points of a slab follow each other, and no point is made through an earlier crack.
/// The order does not depend on the executor. Errors as of MakeOrder.
Result<Order> OrderBySweep(const PointList& points_mm, const OrderOptions& options,
                           const ProgressSink& progress);

}  // namespace intaglio::sort
