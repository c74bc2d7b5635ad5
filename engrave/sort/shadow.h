#pragma once

// How many points of an order are fired through an earlier crack: an independent check
// that shares no code with the sorters.
//
// A point is violated when a crack made earlier lies in the cone above it
// (beam_cone.h; Trochimczuk 2008 ch. 1 and 6.7).

#include <cstdint>
#include <span>

#include "engrave/core/channels.h"
#include "engrave/core/geometry.h"
#include "engrave/sort/beam/beam_cone.h"

namespace intaglio::sort {

/// The violated points, each counted once, of points as they were made one after another,
/// glass frame, mm. cone: in its ranges. About half a
/// microsecond a point, several where many are violated.
std::uint64_t CountShadowViolations(const PointList& made_mm, const BeamCone& cone);

/// Of points that are made in the channels of their masks, one a point: a crack is in the
/// way only in its own channels. A point that is violated in several counts once.
std::uint64_t CountShadowViolations(const PointList& made_mm,
                                    std::span<const ChannelMask> masks,
                                    const BeamCone& cone);

/// Of points in any order, by the places of those that were made one after another; none
/// is copied. `masks`: one a point.
std::uint64_t CountShadowViolations(const PointList& points_mm,
                                    std::span<const ChannelMask> masks,
                                    std::span<const std::uint32_t> made_order,
                                    const BeamCone& cone);

}  // namespace intaglio::sort
