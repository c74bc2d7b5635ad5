#pragma once

// The order of a job's points, for the sorter, previews and the commands without
// services.

#include <span>

#include "engrave/core/channels.h"
#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/sort/order.h"
#include "proto/task.pb.h"
#include "services/job/plan/plan_summary.h"

namespace intaglio {

/// Orders by the method of the job. `options`: OrderOptionsOf(job), with workers and a
/// time budget. `masks`: the channels of each point.
///
/// Points on one lattice (rows.h) have straight rows, which take up to a third fewer
/// ticks than a greedy order where the stage is too slow for a point a tick
/// (docs/measurements.md), and more elsewhere: the job's own plan of both decides with
/// which of them annealing begins. Errors: those of MakeChannelOrder.
Result<sort::Order> OrderPoints(const FrozenJob& job, const PointList& points_mm,
                                std::span<const ChannelMask> masks,
                                const sort::OrderOptions& options,
                                const ProgressSink& progress);

/// The plan of the points in this order, as if it were never paused; at least one.
/// Errors: those of the axes' reach; kCancelled.
Result<PlanSummary> SummarizeOrder(const FrozenJob& job, const PointList& points_mm,
                                   std::span<const ChannelMask> masks,
                                   const sort::Order& order,
                                   const ProgressSink& progress);

}  // namespace intaglio
