#pragma once

#include "engrave/sort/order.h"
#include "proto/task.pb.h"

namespace intaglio::host {

/// OrderOptionsOf(job) with all cores to compute on and, where the job gives an order its
/// time (AnnealOrder.time_s), a clock that begins to run now.
sort::OrderOptions OrderingOf(const FrozenJob& job);

}  // namespace intaglio::host
