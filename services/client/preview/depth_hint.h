#pragma once

// A scan head whose z is too slow for the job's tolerance in depth waits at many ticks.
// How much time a larger tolerance saves is found by estimating again.

#include <optional>

#include "engrave/core/warning.h"
#include "services/client/preview/preview_time.h"

namespace intaglio::client {

/// A note with both times, where a tolerance of a third of the crack's length saves a
/// tenth of `time` or more; nullopt: it does not, the order is none of slabs, or the job
/// has a slab of its own. Errors as of EstimateTime.
Result<std::optional<Warning>> SlowDepthAxisIn(const FrozenJob& job,
                                               const TimePreview& time,
                                               const CloudToTime& cloud,
                                               std::size_t max_planned_points,
                                               const Executor& executor,
                                               const ProgressSink& progress);

}  // namespace intaglio::client
