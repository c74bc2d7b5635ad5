#pragma once

// The machining time of a cloud before it is ordered: parts of it are ordered and planned
// as the whole will be, and the whole takes as many ticks for each point as their middle
// halves do (steady_ticks.h).

#include <cstdint>
#include <span>

#include "engrave/core/channels.h"
#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/sort/order.h"
#include "proto/task.pb.h"

namespace intaglio {

struct EstimateOptions {
  /// Parts, and points of each, in an order of slabs kSweepSampleRatio as many; a cloud
  /// that has no more points in all is planned whole.
  std::size_t sample_count = 4;
  std::size_t sample_points = 2500;
};

/// Whether the estimate orders and plans the whole cloud as the job does: then its order
/// is there as early, and the plan of it is better (point_order.h).
bool EstimatesWhole(const FrozenJob& job, std::size_t point_count,
                    const EstimateOptions& options = {});

/// Ticks from the first point to the last, without pauses, at full speed. `masks`: the
/// channels of each point. A time budget of the order (AnnealOrder.time_s) is not used:
/// its default number of changes is tried. Errors: those of the order and of the axes'
/// reach; kCancelled. 0 for a cloud of one point.
Result<std::uint64_t> FirstEstimateTicks(const FrozenJob& job, const PointList& points_mm,
                                         std::span<const ChannelMask> masks,
                                         const Executor& executor,
                                         const ProgressSink& progress,
                                         const EstimateOptions& options = {});

}  // namespace intaglio
