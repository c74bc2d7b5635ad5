#pragma once

// Cuts a cloud whose points are made in different channels into groups of one mask each,
// to be made one after another. A shutter is mechanical: it is moved between groups, with
// the stage at rest, so they should be few.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/geometry.h"
#include "engrave/core/progress.h"
#include "engrave/sort/beam/beam_cone.h"

namespace intaglio::sort {

/// Indices of the points of each group, lower points first; consecutive groups differ in
/// their mask. Made one after another, whatever the order within, no group's crack shades
/// a point of a later group that shares a channel with it. Empty when `progress`
/// requested cancellation, or there are no points. points_mm: finite, glass frame, mm;
/// masks: one per point, not 0.
std::vector<std::vector<std::uint32_t>> GroupByChannels(
    const PointList& points_mm, std::span<const ChannelMask> masks, const BeamCone& cone,
    const ProgressSink& progress);

}  // namespace intaglio::sort
