#pragma once

// The segments of one step between two states in whole ticks: one cubic when it keeps
// the limits, being the course with the least integral of squared acceleration; else
// on each axis that needs it up to three arcs of constant acceleration (axis_reach.h).

#include <cstdint>
#include <vector>

#include "engrave/motion/limits.h"
#include "engrave/motion/segment.h"

namespace intaglio::motion {

/// `limits` less what AppendStep needs: arcs begin and end on a grid of 0.2 to 0.4 us,
/// which in steps of one tick costs a share of the limits: 1.2e-4 of the acceleration at
/// 100 Hz, 4e-3 at 4 kHz. A speed limit stays positive while the axis takes longer than
/// a microsecond to reach it.
Limits LimitsForPlanning(const Limits& limits, double rate_hz);

/// Appends the step; its last segment ends in `to` exactly. The step is feasible within
/// LimitsForPlanning(limits); ticks >= 1.
void AppendStep(const KnotState& from, const KnotState& to, std::uint32_t ticks,
                const Limits& limits, double rate_hz, std::vector<Segment>& out);

}  // namespace intaglio::motion
