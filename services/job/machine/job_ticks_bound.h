#pragma once

// The bound of engrave/sort/ticks_bound.h for the places of a job on the machine's axes.

#include <cstdint>
#include <optional>

#include "engrave/core/executor.h"
#include "engrave/core/geometry.h"
#include "engrave/motion/planner.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// From the first pulse's tick to the last's, both counted, as PlannedMotion.ticks.
/// `axes`: at the points, in any order. None of no points, and where an axis turns: it
/// may come to a place by more than one way.
std::optional<std::uint64_t> JobTicksBound(const MachineSpec& machine, PointList axes,
                                           const motion::PlanOptions& plan,
                                           const Executor& executor = {});

}  // namespace intaglio
