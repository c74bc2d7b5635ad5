#pragma once

// The order for two fast axes above a slow one, as of a scan head over a block: z goes up
// once and may pass each point a tolerance beside its height (motion/sweep_course.h), so
// from point to point only x and y count. Below a scan head whose beams lean, equal
// heights of the lens reach a bent surface in the glass. It begins in thin slabs or in
// rounds (sweep_begin.h), whichever takes fewer ticks on a sample; then pieces of the
// order are changed so that the mirrors need fewer ticks without stopping (stretch.h).

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/sort/order.h"

namespace intaglio::sort {

Status CheckSweepOptions(const OrderOptions& options);

/// There is a course of z, steadily up, that passes each point within the tolerance, and
/// no point is made through an earlier crack. The order does not depend on the executor.
/// Errors as of MakeOrder.
Result<Order> OrderBySweep(const PointList& points_mm, const OrderOptions& options,
                           const ProgressSink& progress);

}  // namespace intaglio::sort
