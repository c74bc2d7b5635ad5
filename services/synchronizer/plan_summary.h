#pragma once

// The plan of a job as if nothing were ever paused: what is foretold of it, and what two
// runs of one job are compared by.

#include <cstdint>
#include <span>
#include <string>

#include "engrave/core/channels.h"
#include "engrave/motion/planner.h"

namespace intaglio::synchronizer {

struct PlanSummary {
  std::uint64_t ticks = 0;  ///< to the last point
  std::string checksum;     ///< CRC-32 of all segments, hexadecimal
  motion::PointMoves moves;
};

/// `machine_points_mm`: in the order of engraving, machine frame, one at least. `masks`:
/// of each point, for the stage rests where they change; empty: they never do.
PlanSummary Summarize(const PointList& machine_points_mm, const motion::PlanOptions& plan,
                      std::span<const ChannelMask> masks = {});

}  // namespace intaglio::synchronizer
