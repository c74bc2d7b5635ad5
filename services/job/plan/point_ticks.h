#pragma once

// The ticks of points before the sorter orders them: a preview and a first estimate order
// and plan a sample of a cloud here as the whole will be.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "proto/task.pb.h"

namespace intaglio {

/// The tick of each point in the order of the job, from the start. At least one point;
/// `masks`: the channels of each. A time budget of the order (AnnealOrder.time_s) is not
/// used: its default number of changes is tried. `executor`: for the order. Errors: those
/// of the order and of the axes' reach; kCancelled when `progress`, which may be empty,
/// returns false.
Result<std::vector<std::uint32_t>> PointTicks(const FrozenJob& job,
                                              const PointList& points_mm,
                                              std::span<const ChannelMask> masks,
                                              const Executor& executor,
                                              const ProgressSink& progress);

}  // namespace intaglio
