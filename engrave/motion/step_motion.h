#pragma once

// The segments of one step between two states in whole ticks: the courses of the axes
// (step_course.h), cut wherever a piece of any of them ends.

#include <cstdint>
#include <vector>

#include "engrave/motion/segments/segment.h"
#include "engrave/motion/step_limits.h"

namespace intaglio::motion {

/// Appends the step; its last segment ends in `to` exactly. The step is feasible within
/// the planned limits; ticks >= 1.
void AppendStep(const KnotState& from, const KnotState& to, std::uint32_t ticks,
                const StepLimits& limits, double rate_hz, std::vector<Segment>& out);

}  // namespace intaglio::motion
