#pragma once

// Sort by annealing: the order of smooth.h, or rows (AnnealStart), changed piece by piece
// (stretch.h) for as long as the options allow, so that the stage needs fewer ticks.
// Where that is as long as it is worth it, a local search (stretch_search.h) follows a
// short annealing. Never through an earlier crack, and never worse than the initial
// order: in the end the motion planner decides.

#include "engrave/sort/order.h"

namespace intaglio::sort {

Status CheckAnnealOptions(const OrderOptions& options);

/// The first point is that of the order it begins with. The same whatever the executor
/// does at the same time, as long as options.anneal.used_share is not given. Memory: that
/// of smooth.h, and some megabytes for each worker. Points and options must have been
/// checked by MakeOrder.
Result<Order> OrderByAnnealing(const PointList& points_mm, const OrderOptions& options,
                               const ProgressSink& progress);

/// Anneals `order`, whose points must all obey options.cone. Returns the given order when
/// that is better, or so near the bound that nothing can be gained. Empty when `progress`
/// requested cancellation.
Order ImproveOrder(const PointList& points_mm, Order order, const OrderOptions& options,
                   const ProgressSink& progress);

}  // namespace intaglio::sort
